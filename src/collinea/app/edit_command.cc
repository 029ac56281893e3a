// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <iostream>
#include <iterator>
#include <limits>

#include "collinea/app/commands.h"
#include "collinea/app/console.h"
#include "collinea/base/file.h"
#include "collinea/edit/make_edits.h"
#include "collinea/edit/read_edits.h"
#include "collinea/serve/edits_json.h"

namespace collinea {
namespace {

struct Asked {
  std::string project;
  std::vector<std::string> words;
  bool json = false;
};

std::string table_of(const EditHistory& history) {
  std::string text;
  for (const EditEntry& entry : history.entries())
    text += fmt::format("{:>6}  {:<20}  {:<6}  {}{}\n", entry.number, entry.time, entry.undone ? "undone" : "",
                        line_of(words_of(entry.edit)), entry.target > 0 ? fmt::format(" (edit {})", entry.target) : "");
  return text;
}

Result<std::string> listed_edits(const Asked& asked) {
  Journal journal(asked.project);
  if (!is_there(std::filesystem::path(asked.project) / "project.json"))
    return fail(Errc::kNotFound, asked.project + " is not a project: no project.json in it");
  COLLINEA_TRY(journal.refresh());
  if (asked.json) return edits_json(journal.history(), 0, std::numeric_limits<std::size_t>::max()) + "\n";
  return table_of(journal.history());
}

Result<std::vector<Edit>> replayed_edits(const std::string& file) {
  constexpr std::uint64_t kLongest = std::uint64_t{1} << 28;
  const bool is_input = file == "-";
  std::string text;
  if (is_input) {
    text.assign(std::istreambuf_iterator<char>(std::cin), {});
  } else {
    COLLINEA_TRY(text, read_file(file, kLongest));
  }
  return read_edits(text).map_error(
      [&](Error error) { return std::move(error).within(is_input ? "standard input" : file); });
}

Result<std::vector<Edit>> asked_edits(const std::vector<std::string>& words) {
  if (words[0] == "replay") {
    if (words.size() != 2)
      return fail(Errc::kBadInput, "the command is written: replay FILE, or replay - for standard input");
    return replayed_edits(words[1]);
  }
  return parse_edit(words).map([](Edit edit) { return std::vector<Edit>{std::move(edit)}; }).map_error([](Error error) {
    return std::move(error).advising("; or list, replay");
  });
}

std::string said(const Journal& journal, std::uint64_t before) {
  std::string text;
  for (const EditEntry& entry : journal.history().entries().subspan(before))
    text += fmt::format("edit {}: {}{}\n", entry.number, line_of(words_of(entry.edit)),
                        entry.target > 0 ? " " + line_of(words_of(journal.history().at(entry.target).edit)) : "");
  return text;
}

Result<std::string> edited(const Asked& asked) {
  if (asked.words[0] == "list" && asked.words.size() == 1) return listed_edits(asked);
  COLLINEA_TRY(const std::vector<Edit> edits, asked_edits(asked.words));
  Journal journal(asked.project);
  COLLINEA_TRY(const EditsMade made, make_edits(asked.project, journal, edits));
  if (made.waiting)
    fmt::print(stderr, "note: kept, and taken into the database before the next step: {}\n", made.waiting->message);
  if (asked.json) return fmt::format("{{\"number\":{}}}\n", made.number);
  return said(journal, made.number - edits.size());
}

std::string help_of_words() {
  std::string help;
  for (const std::string_view form : edit_forms()) help += (help.empty() ? "" : "; ") + std::string(form);
  return help + "; list; replay FILE";
}

}  // namespace

Command edit_command() {
  auto asked = std::make_shared<Asked>();
  return {"edit", "control points and their marks in images changed by hand, with undo",
          [asked](Flags& flags) {
            flags.positional("project", asked->project, "project folder");
            flags.words("command", asked->words, help_of_words());
            flags.add("json", asked->json, "", "as JSON, for machines");
          },
          [asked](const Flags&) {
            const auto text = edited(*asked);
            if (!text) return complain(text.error());
            std::fputs(text->c_str(), stdout);
            return 0;
          }};
}

}  // namespace collinea
