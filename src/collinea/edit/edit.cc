// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/edit.h"

#include <utility>

#include "collinea/edit/internal/words_in.h"

namespace collinea {
namespace {

// Calls visit(std::type_identity<Kind>()) for each kind of the list.
template <class Visit, std::size_t... kIndex>
void for_each_kind(Visit&& visit, std::index_sequence<kIndex...>) {
  (visit(std::type_identity<std::variant_alternative_t<kIndex, Edit>>()), ...);
}
template <class Visit>
void for_each_kind(Visit&& visit) {
  for_each_kind(visit, std::make_index_sequence<std::variant_size_v<Edit>>());
}

template <class Kind>
Result<Edit> parsed(std::span<const std::string> words) {
  if constexpr (requires { Kind::parse(words); }) {
    return Kind::parse(words).map([](Kind kind) { return Edit(std::move(kind)); });
  } else {
    if (!words.empty()) return wrong_form(Kind::kForm);
    return Edit(Kind{});
  }
}

bool needs_quotes(const std::string& word) {
  return word.empty() || word.front() == '#' || word.find_first_of(" \t\"\\") != std::string::npos;
}

}  // namespace

Result<Edit> parse_edit(std::span<const std::string> words) {
  std::string known;
  std::optional<Result<Edit>> edit;
  for_each_kind([&](auto kind) {
    using Kind = typename decltype(kind)::type;
    known += (known.empty() ? "" : ", ") + std::string(Kind::kWord);
    if (!words.empty() && words[0] == Kind::kWord) edit = parsed<Kind>(words.subspan(1));
  });
  if (edit) return *std::move(edit);
  if (words.empty()) return fail(Errc::kBadInput, "no command is given: one of " + known);
  return fail(Errc::kBadInput, "no command is called \"" + words[0].substr(0, 40) + "\": one of " + known);
}

std::vector<std::string> words_of(const Edit& edit) {
  return std::visit(
      [](const auto& kind) {
        if constexpr (requires { kind.words(); })
          return command_words(kind);
        else
          return std::vector<std::string>{std::string(kind.kWord)};
      },
      edit);
}

bool is_of_history(const Edit& edit) {
  return std::holds_alternative<Undo>(edit) || std::holds_alternative<Redo>(edit);
}

const std::string& point_of(const Edit& edit) {
  static const std::string none;
  return std::visit(
      [](const auto& kind) -> const std::string& {
        if constexpr (requires { kind.point; })
          return kind.point;
        else
          return none;
      },
      edit);
}

std::vector<std::string_view> edit_forms() {
  std::vector<std::string_view> forms;
  for_each_kind([&](auto kind) { forms.push_back(decltype(kind)::type::kForm); });
  return forms;
}

std::string line_of(std::span<const std::string> words) {
  std::string line;
  for (const std::string& word : words) {
    if (!line.empty()) line += ' ';
    if (!needs_quotes(word)) {
      line += word;
      continue;
    }
    line += '"';
    for (const char c : word) {
      if (c == '"' || c == '\\') line += '\\';
      line += c;
    }
    line += '"';
  }
  return line;
}

Result<std::vector<std::string>> words_in_line(std::string_view line) {
  std::vector<std::string> words;
  bool in_word = false, in_quotes = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    char c = line[i];
    const bool is_space = c == ' ' || c == '\t' || c == '\r';
    if (is_space && !in_quotes) {
      in_word = false;
      continue;
    }
    if (!in_word) words.emplace_back();
    in_word = true;
    if (c == '"') {
      in_quotes = !in_quotes;
      continue;
    }
    if (c == '\\' && in_quotes) {
      if (++i == line.size()) break;
      c = line[i];
    }
    words.back() += c;
  }
  if (in_quotes) return fail(Errc::kBadInput, "a quotation mark is not closed");
  return words;
}

}  // namespace collinea
