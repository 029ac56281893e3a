// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/options.h"

#include <array>
#include <charconv>

namespace collinea {
namespace {

std::string number_text(double value) {
  std::array<char, 32> digits{};
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value, std::chars_format::general, 12);
  return {digits.data(), end.ptr};
}

std::string range_text(double min, double max) {
  if (std::isfinite(min) && std::isfinite(max)) return number_text(min) + " to " + number_text(max);
  if (std::isfinite(min)) return number_text(min) + " and more";
  if (std::isfinite(max)) return "up to " + number_text(max);
  return "a number";
}

}  // namespace

Error out_of_range(std::string_view name, std::string_view unit, double value, double min, double max) {
  const std::string of_unit = unit.empty() || unit == "1" ? "" : " " + std::string(unit);
  return Error{
      Errc::kBadInput,
      std::string(name) + " = " + number_text(value) + of_unit + " is out of range: " + range_text(min, max) + of_unit,
      {OptionName{std::string(name)}}};
}

Error not_a_choice(std::string_view name, std::string_view word, std::span<const Choice> choices) {
  std::vector<std::string_view> known;
  for (const Choice& choice : choices) known.push_back(choice.word);
  return Error{Errc::kBadInput,
               std::string(name) + " = \"" + std::string(word) + "\": choose " + listed(known),
               {OptionName{std::string(name)}}};
}

}  // namespace collinea
