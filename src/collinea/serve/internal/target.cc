// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/target.h"

namespace collinea {
namespace {

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    int byte = static_cast<unsigned char>(text[i]);
    if (text[i] == '%') {
      const int high = i + 2 < text.size() ? hex_digit(text[i + 1]) : -1;
      const int low = i + 2 < text.size() ? hex_digit(text[i + 2]) : -1;
      if (high < 0 || low < 0) return std::nullopt;
      byte = 16 * high + low;
      i += 2;
    }
    if (byte < 0x20 || byte == 0x7f) return std::nullopt;
    out += static_cast<char>(byte);
  }
  return out;
}

// Calls take(part) for what stands between the separators; whether all of them could be taken.
template <class Take>
bool for_each_part(std::string_view text, char separator, Take&& take) {
  while (true) {
    const std::size_t end = text.find(separator);
    if (!take(text.substr(0, end))) return false;
    if (end == std::string_view::npos) return true;
    text.remove_prefix(end + 1);
  }
}

}  // namespace

std::optional<Target> parsed_target(std::string_view target) {
  if (!target.starts_with('/')) return std::nullopt;
  target = target.substr(0, target.find('#'));
  const std::size_t question = target.find('?');
  const std::string_view path = target.substr(1, question == std::string_view::npos ? question : question - 1);
  Target out;
  const bool whole_path = path.empty() || for_each_part(path, '/', [&](std::string_view part) {
                            auto name = unescaped(part);
                            if (name) out.path.push_back(std::move(*name));
                            return name.has_value();
                          });
  if (!whole_path) return std::nullopt;
  if (question == std::string_view::npos) return out;
  const bool whole_query = for_each_part(target.substr(question + 1), '&', [&](std::string_view part) {
    const std::size_t equals = part.find('=');
    auto name = unescaped(part.substr(0, equals));
    auto value = unescaped(equals == std::string_view::npos ? std::string_view() : part.substr(equals + 1));
    if (name && value) out.query.emplace(std::move(*name), std::move(*value));
    return name && value;
  });
  return whole_query ? std::optional(std::move(out)) : std::nullopt;
}

}  // namespace collinea
