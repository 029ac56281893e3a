// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/internal/separators.h"

#include <algorithm>

#include "collinea/io/text.h"

namespace collinea {
namespace {

bool has(std::string_view line, char c) { return line.find(c) != std::string_view::npos; }

std::string plural_of(char separator) {
  if (separator == ',') return "commas";
  if (separator == ';') return "semicolons";
  return separator == '\t' ? "tabs" : "blanks";
}

bool is_digits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

char separator_of_titles(std::string_view titles) {
  for (const char separator : {',', ';', '\t'})
    if (has(titles, separator)) return separator;
  return ',';
}

std::vector<std::string_view> fields_between(std::string_view line, char separator) {
  return fields_of(separator == '\t' ? line : trimmed(line), separator);
}

bool has_decimal_comma(std::string_view field) {
  field = trimmed(field);
  if (field.starts_with('-') || field.starts_with('+')) field.remove_prefix(1);
  const auto comma = field.find(',');
  return comma != std::string_view::npos && is_digits(field.substr(0, comma)) && is_digits(field.substr(comma + 1));
}

std::string number_hint(std::string_view field) {
  if (!has_decimal_comma(field)) return {};
  std::string with_point(trimmed(field));
  with_point[with_point.find(',')] = '.';
  return " (a decimal comma? Write " + with_point + ")";
}

std::string separator_hint(std::string_view line, char expected) {
  const std::vector<std::string_view> words = words_of(line);
  const bool by_blanks = expected == ' ';
  if (!by_blanks && has(line, expected)) return {};
  if (const auto number = std::find_if(words.begin(), words.end(), has_decimal_comma);
      by_blanks && number != words.end())
    return number_hint(*number);
  for (const char found : {';', '\t', ','}) {
    const bool is_other = found != expected && !(by_blanks && found == '\t');
    if (is_other && has(line, found))
      return " (" + plural_of(found) + " in the line; " + plural_of(expected) + " are expected)";
  }
  if (!by_blanks && words.size() > 1) return " (blanks in the line; " + plural_of(expected) + " are expected)";
  return {};
}

}  // namespace collinea
