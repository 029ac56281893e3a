// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/content_coding.h"

#include <algorithm>
#include <string>

namespace collinea {
namespace {

// In lower case, without spaces.
std::string plain_text(std::string_view header) {
  std::string plain;
  for (const char c : header)
    if (c != ' ' && c != '\t') plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return plain;
}

// "q=0", "q=0.000".
bool has_no_weight(std::string_view parameters) {
  return parameters.starts_with("q=0") && parameters.find_first_not_of("0.", 2) == std::string_view::npos;
}

}  // namespace

bool allows_gzip(std::string_view accept_encoding) {
  const std::string plain = plain_text(accept_encoding);
  bool others = false;
  for (std::string_view rest = plain; !rest.empty();) {
    const std::string_view one = rest.substr(0, rest.find(','));
    rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    const std::size_t end = std::min(one.find(';'), one.size());
    const bool allowed = !has_no_weight(one.substr(std::min(one.size(), end + 1)));
    if (one.substr(0, end) == "gzip") return allowed;
    if (one.substr(0, end) == "*") others = allowed;
  }
  return others;
}

}  // namespace collinea
