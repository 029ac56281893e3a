// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/word_or.h"

#include <charconv>
#include <cmath>

namespace collinea {

std::optional<double> number_in(std::string_view text) {
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<ThreeNumbers> three_numbers_in(std::string_view text) {
  ThreeNumbers numbers{};
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    while (at < end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, numbers[i]);
    const bool is_last = i + 1 == numbers.size(), parted = is_last ? next == end : next < end && *next == ',';
    if (error != std::errc() || !parted || !std::isfinite(numbers[i])) return std::nullopt;
    if (!is_last) at = next + 1;
  }
  return numbers;
}

}  // namespace collinea
