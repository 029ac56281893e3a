// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

// A client of the server that shares no code with it: sockets alone.
namespace collinea::testing {

/// What came back: the text of the head, and the body.
struct Answer {
  int status = 0;
  std::string head, body;

  /// The value of a header, named as the server writes it; empty: there is none.
  [[nodiscard]] std::string header(const std::string& name) const {
    const std::size_t at = head.find("\r\n" + name + ": ");
    if (at == std::string::npos) return {};
    const std::size_t begin = at + name.size() + 4;
    return head.substr(begin, head.find("\r\n", begin) - begin);
  }
};

class Connection {
 public:
  explicit Connection(int port) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Connection() { ::close(socket_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }
  /// The other end has not closed, and nothing has come that was not read.
  [[nodiscard]] bool open() const {
    char byte = 0;
    return ::recv(socket_, &byte, 1, MSG_PEEK | MSG_DONTWAIT) < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
  }

  /// Sends what the other end takes.
  void send(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
      if (count <= 0) return;
      text.remove_prefix(static_cast<std::size_t>(count));
    }
  }
  void end_sending() const { ::shutdown(socket_, SHUT_WR); }

  /// The bytes asked for, or fewer where the other end closes.
  std::string read(std::size_t count) {
    while (pending_.size() < count && fill()) {
    }
    const std::string text = pending_.substr(0, count);
    pending_.erase(0, count);
    return text;
  }
  /// Everything until the other end closes.
  std::string read_all() {
    while (fill()) {
    }
    return std::exchange(pending_, {});
  }
  /// One answer; nothing when the other end closes before it is whole.
  std::optional<Answer> read_answer(bool has_body = true) {
    std::size_t end = std::string::npos;
    while ((end = pending_.find("\r\n\r\n")) == std::string::npos)
      if (!fill()) return std::nullopt;
    Answer answer;
    answer.head = read(end + 4);
    answer.status = std::atoi(answer.head.substr(9, 3).c_str());
    const std::size_t size = std::strtoul(answer.header("Content-Length").c_str(), nullptr, 10);
    if (has_body) answer.body = read(size);
    if (has_body && answer.body.size() != size) return std::nullopt;
    return answer;
  }

 private:
  bool fill() {
    char bytes[4096];
    const ssize_t count = ::recv(socket_, bytes, sizeof bytes, 0);
    if (count <= 0) return false;
    pending_.append(bytes, static_cast<std::size_t>(count));
    return true;
  }

  int socket_;
  bool connected_ = false;
  std::string pending_;
};

/// The text of one unfragmented message of a WebSocket (RFC 6455, 5.2); nothing when it closes.
inline std::optional<std::string> read_message(Connection& connection) {
  const std::string start = connection.read(2);
  if (start.size() < 2 || (start[0] & 0x0f) != 1) return std::nullopt;
  std::size_t size = static_cast<unsigned char>(start[1]) & 0x7f;
  const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
  if (more > 0) {
    size = 0;
    for (const char byte : connection.read(more)) size = 256 * size + static_cast<unsigned char>(byte);
  }
  std::string text = connection.read(size);
  return text.size() == size ? std::optional(std::move(text)) : std::nullopt;
}

}  // namespace collinea::testing
