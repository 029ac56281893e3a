// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "collinea/base/result.h"
#include "collinea/serve/message.h"
#include "collinea/serve/routes.h"

namespace collinea {

/// What one client may use up.
struct ServerLimits {
  int connections = 64;  ///< at once; further ones are closed
  int header_bytes = 16 * 1024;
  int body_bytes = 512 * 1024;  ///< an outline of thousands of points is drawn in one edit
  int idle_s = 30;              ///< until a request has come whole, and for each 256 KiB of an answer to go
};

/// Where a server listens.
struct ServerAddress {
  std::string text;             ///< in the shortest form, without a zone: "127.0.0.1", "::1"
  bool is_loopback = false;     ///< of this machine alone
  bool is_unspecified = false;  ///< of all interfaces
};

/// The only user of Boost.Beast: it reads and writes HTTP/1.1 and WebSockets; what is answered, `answer` says.
class Server {
 public:
  /// Takes the port of an address, such as 127.0.0.1; port 0: any that is free. Errors: no address, port taken or not
  /// allowed.
  static Result<Server> listen(const std::string& address, int port, const ServerLimits& limits = {});
  [[nodiscard]] int port() const;
  [[nodiscard]] const ServerAddress& address() const;

  /// Answers until a stop is requested.
  void run(Site& site, std::stop_token stop);

  Server(Server&&) noexcept;
  Server& operator=(Server&&) = delete;
  ~Server();

 private:
  Server();
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace collinea
