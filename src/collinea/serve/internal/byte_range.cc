// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/byte_range.h"

#include <algorithm>
#include <limits>
#include <optional>

namespace collinea {
namespace {

// A number of digits alone; what is too large for 64 bits is the largest there is: it lies beyond every file.
std::optional<std::uint64_t> digits_in(std::string_view text) {
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();
  if (text.empty()) return std::nullopt;
  std::uint64_t value = 0;
  for (const char c : text) {
    if (c < '0' || c > '9') return std::nullopt;
    const auto digit = static_cast<std::uint64_t>(c - '0');
    value = value > (kLargest - digit) / 10 ? kLargest : 10 * value + digit;
  }
  return value;
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

}  // namespace

ByteRange asked_range(std::string_view header, std::uint64_t file_size) {
  constexpr ByteRange kNone{ByteRange::Kind::kUnsatisfiable};
  header = trimmed(header);
  constexpr std::string_view kUnit = "bytes=";
  if (!header.starts_with(kUnit)) return {};
  const std::string_view spec = trimmed(header.substr(kUnit.size()));
  const std::size_t dash = spec.find('-');
  if (dash == std::string_view::npos) return kNone;
  const auto last = digits_in(spec.substr(dash + 1));
  if (dash == 0) {  // the last so many bytes
    if (!last || *last == 0 || file_size == 0) return kNone;
    const std::uint64_t size = std::min(*last, file_size);
    return {ByteRange::Kind::kPart, file_size - size, size};
  }
  const auto first = digits_in(spec.substr(0, dash));
  const bool open_ended = dash + 1 == spec.size();
  if (!first || (!last && !open_ended) || (last && *last < *first) || *first >= file_size) return kNone;
  const std::uint64_t end = last ? std::min(*last, file_size - 1) : file_size - 1;
  return {ByteRange::Kind::kPart, *first, end - *first + 1};
}

}  // namespace collinea
