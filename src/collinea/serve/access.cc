// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/access.h"

#include <sys/random.h>

#include <algorithm>
#include <array>

#include "collinea/base/result.h"
#include "collinea/serve/internal/json_answer.h"

namespace collinea {
namespace {

// An address of digits, with a bracket around those of IPv6.
bool is_address(std::string_view host) {
  if (host.empty()) return false;
  if (host.starts_with('[') && host.ends_with(']'))
    return host.find_first_not_of("0123456789abcdefABCDEF:.[]") == std::string_view::npos;
  return std::count(host.begin(), host.end(), '.') == 3 &&
         host.find_first_not_of("0123456789.") == std::string_view::npos;
}

std::string in_lower_case(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return out;
}

}  // namespace

bool is_own_host(std::string_view host, const ServerNames& names) {
  const std::string port = ":" + std::to_string(names.port);
  if (host.ends_with(port))
    host.remove_suffix(port.size());
  else if (names.port != 80)  // which browsers leave out
    return false;
  const std::string name = in_lower_case(host);
  if (std::find(names.hosts.begin(), names.hosts.end(), name) != names.hosts.end()) return true;
  return names.any_address && is_address(name);
}

bool is_own_origin(std::string_view origin, std::string_view host) {
  return origin.empty() || in_lower_case(origin) == "http://" + in_lower_case(host);
}

std::string_view cookie_in(std::string_view header, std::string_view name) {
  while (!header.empty()) {
    const std::size_t end = header.find(';');
    std::string_view one = header.substr(0, end);
    while (one.starts_with(' ')) one.remove_prefix(1);
    if (one.size() > name.size() && one.starts_with(name) && one[name.size()] == '=')
      return one.substr(name.size() + 1);
    if (end == std::string_view::npos) break;
    header.remove_prefix(end + 1);
  }
  return {};
}

bool is_same_secret(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i) difference |= static_cast<unsigned char>(a[i] ^ b[i]);
  return difference == 0;
}

std::string new_secret() {
  std::array<unsigned char, 32> bytes{};
  COLLINEA_CHECK(::getrandom(bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  std::string text;
  for (const unsigned char byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

Access::Access(ServerNames names) : names_(std::move(names)) {}

std::optional<HttpResponse> Access::foreign(const HttpRequest& request) const {
  const std::string_view host = request.header("host");
  if (!is_own_host(host, names_))
    return error_answer(403, "This server has another name than the one it was called by.");
  if (!is_own_origin(request.header("origin"), host))
    return error_answer(403, "Pages of other sites may ask nothing here.");
  return std::nullopt;
}

std::optional<HttpResponse> Access::refusal(const HttpRequest& request) const {
  if (auto response = foreign(request)) return response;
  if (is_same_secret(cookie_in(request.header("cookie"), cookie_name()), session_)) return std::nullopt;
  return error_answer(401, "Open the link that `collinea serve` showed last; each serves once.");
}

std::optional<std::string> Access::exchange(std::string_view token) {
  const std::lock_guard lock(mutex_);
  if (!is_same_secret(token, token_)) return std::nullopt;
  token_ = new_secret();
  return cookie_name() + "=" + session_ + "; Path=/; HttpOnly; SameSite=Strict";
}

std::string Access::link() const {
  const std::lock_guard lock(mutex_);
  return "/?token=" + token_;
}

// Browsers keep cookies by host, not by port: two servers need two names.
std::string Access::cookie_name() const { return "collinea_" + std::to_string(names_.port); }

}  // namespace collinea
