// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace collinea {
namespace {

constexpr std::string_view kBlank = " \t\r\n\v\f";

template <class T>
std::optional<T> parsed(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  T value{};
  const char* end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (text.empty() || error != std::errc{} || stop != end) return std::nullopt;
  return value;
}

void append_utf8(std::uint32_t code, std::string& text) {
  const auto tail = [&](int shift) { text += char(0x80 | ((code >> shift) & 0x3f)); };
  if (code < 0x80) {
    text += char(code);
  } else if (code < 0x800) {
    text += char(0xc0 | (code >> 6));
    tail(0);
  } else if (code < 0x10000) {
    text += char(0xe0 | (code >> 12));
    tail(6), tail(0);
  } else {
    text += char(0xf0 | (code >> 18));
    tail(12), tail(6), tail(0);
  }
}

// RFC 2781: codes above 0xffff are pairs of a high (0xd800) and a low (0xdc00) half.
Result<std::string> utf8_of_utf16(std::string_view bytes, bool big_endian) {
  const auto unit = [&](std::size_t i) {
    const auto first = static_cast<unsigned char>(bytes[i]), second = static_cast<unsigned char>(bytes[i + 1]);
    return big_endian ? std::uint32_t{first} << 8 | second : std::uint32_t{second} << 8 | first;
  };
  std::string text;
  text.reserve(bytes.size() / 2 + 16);
  for (std::size_t i = 2; i < bytes.size(); i += 2) {
    if (i + 1 == bytes.size()) return fail(Errc::kBadFormat, "the file is UTF-16 and ends within a character");
    std::uint32_t code = unit(i);
    const bool is_pair = code >= 0xd800 && code < 0xdc00;
    if (is_pair) {
      i += 2;
      const std::uint32_t low = i + 1 < bytes.size() ? unit(i) : 0;
      if (low < 0xdc00 || low >= 0xe000) return fail(Errc::kBadFormat, "the file is broken UTF-16: save it as UTF-8");
      code = 0x10000 + ((code - 0xd800) << 10) + (low - 0xdc00);
    } else if (code >= 0xdc00 && code < 0xe000) {
      return fail(Errc::kBadFormat, "the file is broken UTF-16: save it as UTF-8");
    }
    append_utf8(code, text);
  }
  return text;
}

// ASCII in UTF-16: every other byte is 0.
bool looks_like_utf16(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 64);
  return 3 * std::count(head.begin(), head.end(), '\0') > std::ssize(head);
}

}  // namespace

Result<std::optional<std::string>> converted_to_utf8(std::string_view bytes) {
  using namespace std::string_view_literals;
  if (bytes.starts_with("\xff\xfe\0\0"sv) || bytes.starts_with("\0\0\xfe\xff"sv))
    return fail(Errc::kBadFormat, "the file is UTF-32: save it as UTF-8");
  const bool big_endian = bytes.starts_with("\xfe\xff");
  std::optional<std::string> converted;
  if (big_endian || bytes.starts_with("\xff\xfe")) {
    COLLINEA_TRY(converted, utf8_of_utf16(bytes, big_endian));
    bytes = *converted;
  }
  const auto nought = bytes.find('\0');
  if (nought == std::string_view::npos) return converted;
  if (!converted && looks_like_utf16(bytes))
    return fail(Errc::kBadFormat, "the file looks like UTF-16 without a byte order mark: save it as UTF-8");
  const std::size_t line = lines_of(bytes.substr(0, nought + 1)).size();
  return fail(Errc::kBadFormat, "line " + std::to_string(line) + ": a byte of 0, which no text has: not a text file");
}

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result)
    if (c >= 'A' && c <= 'Z') c = char(c - 'A' + 'a');
  return result;
}

std::vector<std::string_view> lines_of(std::string_view text) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const auto end = text.find_first_of("\r\n");
    lines.push_back(text.substr(0, end));
    if (end == std::string_view::npos) break;
    const bool both = text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n';
    text.remove_prefix(end + (both ? 2 : 1));
  }
  return lines;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  for (auto first = line.find_first_not_of(kBlank); first != std::string_view::npos;) {
    const auto end = std::min(line.find_first_of(kBlank, first), line.size());
    words.push_back(line.substr(first, end - first));
    first = line.find_first_not_of(kBlank, end);
  }
  return words;
}

std::vector<std::string_view> fields_of(std::string_view line, char separator) {
  std::vector<std::string_view> fields;
  while (true) {
    const auto end = line.find(separator);
    fields.push_back(trimmed(line.substr(0, end)));
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

std::optional<double> number(std::string_view text) { return parsed<double>(text); }

std::optional<double> finite_number(std::string_view text) {
  const auto value = number(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> integer(std::string_view text) { return parsed<std::int64_t>(text); }

std::string exact(double value) {
  char digits[32];
  return {digits, std::to_chars(digits, digits + sizeof(digits), value).ptr};
}

std::string fixed(double value, int decimals) {
  char digits[400];  // 1e308 has 309 digits before the point
  const auto [end, error] = std::to_chars(digits, digits + sizeof(digits), value, std::chars_format::fixed, decimals);
  return error == std::errc{} ? std::string(digits, end) : exact(value);
}

std::string metres_text(double m) { return m < 0.1 ? fmt::format("{:.3g} mm", 1000 * m) : fmt::format("{:.3g} m", m); }

}  // namespace collinea
