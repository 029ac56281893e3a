// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/journal_line.h"

#include <nlohmann/json.hpp>
#include <stdexcept>

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

bool bounded_depth(int depth, json::parse_event_t, json&) {
  constexpr int kDeepest = 3;
  if (depth > kDeepest) throw std::invalid_argument("it is nested too deep");
  return true;
}

}  // namespace

std::string text_of(const JournalLine& line) {
  json one = {{"number", line.number}, {"time", line.time}, {"command", words_of(line.edit)}};
  if (!line.replaced.empty()) one["replaced"] = line.replaced;
  return one.dump();
}

Result<JournalLine> parse_journal_line(std::string_view text) {
  constexpr std::size_t kLongestTime = 40;
  if (text.size() > kLongestLine) return fail(Errc::kBadFormat, "the line is too long");
  try {
    const json one = json::parse(text, bounded_depth);
    JournalLine line;
    if (!one.at("number").is_number_unsigned()) throw std::invalid_argument("the number is no number from 1 on");
    line.number = one.at("number").get<std::uint64_t>();
    line.time = one.at("time").get<std::string>();
    if (line.time.size() > kLongestTime) throw std::invalid_argument("the time is too long");
    if (const auto replaced = one.find("replaced"); replaced != one.end())
      line.replaced = replaced->get<std::vector<Words>>();
    COLLINEA_TRY(line.edit, parse_edit(one.at("command").get<Words>()));
    return line;
  } catch (const std::exception& error) {
    return fail(Errc::kBadFormat, error.what());
  }
}

}  // namespace collinea
