// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/serve/message.h"

namespace collinea {

/// The names under which a server may be called. A page of another site that had its own name point here (DNS
/// rebinding) shows by its `Host`.
struct ServerNames {
  int port = 0;
  std::vector<std::string> hosts = {"127.0.0.1", "localhost", "[::1]"};
  bool any_address = false;  ///< it listens on every interface: any address of digits is its own
};

/// "localhost:8471" against the names.
[[nodiscard]] bool is_own_host(std::string_view host, const ServerNames& names);
/// Of a browser's request: it is of a page of this server ("http://" + host). Empty: no browser, or a page that the
/// user opened.
[[nodiscard]] bool is_own_origin(std::string_view origin, std::string_view host);
/// The value of a cookie; empty: there is none.
[[nodiscard]] std::string_view cookie_in(std::string_view header, std::string_view name);
/// Takes the same time wherever two texts differ.
[[nodiscard]] bool is_same_secret(std::string_view a, std::string_view b);
/// 256 random bits in hexadecimal digits, from the operating system.
[[nodiscard]] std::string new_secret();

/// Who may come in: those with the cookie, which a link gives once.
class Access {
 public:
  explicit Access(ServerNames names);

  /// Why a request is not answered: 403 of a foreign host or origin, 401 without the cookie.
  [[nodiscard]] std::optional<HttpResponse> refusal(const HttpRequest& request) const;
  /// The same of host and origin alone.
  [[nodiscard]] std::optional<HttpResponse> foreign(const HttpRequest& request) const;

  /// The cookie for a token, as `Set-Cookie` has it; nothing when it is not the one of the last link. A link serves
  /// once: another one follows it.
  [[nodiscard]] std::optional<std::string> exchange(std::string_view token);
  /// "/?token=...".
  [[nodiscard]] std::string link() const;
  [[nodiscard]] std::string cookie_name() const;

 private:
  ServerNames names_;
  std::string session_ = new_secret();
  mutable std::mutex mutex_;
  std::string token_ = new_secret();
};

}  // namespace collinea
