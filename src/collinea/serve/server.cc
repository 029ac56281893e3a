// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/server.h"

#include <fcntl.h>

#include <utility>  // Boost 1.74 uses std::exchange without it

#include <algorithm>
#include <atomic>
#include <boost/asio.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "collinea/serve/internal/json_answer.h"
#include "collinea/serve/project_files.h"
#include "collinea/serve/project_json.h"

namespace collinea {
namespace {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using boost::system::error_code;
using net::ip::tcp;

constexpr int kIoThreads = 4;                             // one may wait for a disk or the database
constexpr std::chrono::milliseconds kEventInterval(100);  // between looks at what changed
constexpr std::size_t kChunkBytes = 256 * 1024;           // of a file in memory
constexpr std::chrono::seconds kLinger(2);                // at the end of a connection
constexpr std::size_t kMostUnread = 1024 * 1024;

/// What all connections of a server share.
struct Shared {
  Shared(const ServerLimits& bounds, Site& served) : limits(bounds), site(served) {}
  ServerLimits limits;
  Site& site;
  std::atomic<int> connections = 0;
};

/// Counts a connection as long as it is open.
class Seat {
 public:
  explicit Seat(std::shared_ptr<Shared> shared) : shared_(std::move(shared)) { ++shared_->connections; }
  ~Seat() { --shared_->connections; }
  Seat(const Seat&) = delete;
  Seat& operator=(const Seat&) = delete;

 private:
  std::shared_ptr<Shared> shared_;
};

auto completion(error_code& error) { return net::redirect_error(net::use_awaitable, error); }

// Takes the body out of the message.
HttpRequest plain(http::request<http::string_body>& message) {
  HttpRequest request;
  request.method = std::string(message.method_string());
  request.target = std::string(message.target());
  for (const auto& field : message) {
    std::string name(field.name_string());
    for (char& c : name)
      if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    const auto [known, is_new] = request.headers.emplace(name, std::string(field.value()));
    if (!is_new)
      known->second =
          name == "host" ? "" : known->second + (name == "cookie" ? "; " : ", ") + std::string(field.value());
  }
  request.body = std::move(message.body());
  return request;
}

HttpResponse answer_guarded(const HttpRequest& request, Site& site) {
  try {
    return answer(request, site);
  } catch (const std::exception& error) {  // one request that goes wrong is no end of the server
    return error_answer(500, std::string("defect in the program: ") + error.what());
  } catch (...) {
    return error_answer(500, "defect in the program");
  }
}

/// What is wrong with a request that could not be read; 0: the other end is gone or silent.
int status_of(error_code error) {
  if (error == http::error::end_of_stream || error == http::error::partial_message) return 0;
  if (error == http::error::header_limit || error == http::error::buffer_overflow) return 431;
  if (error == http::error::body_limit) return 413;
  return error.category() == make_error_code(http::error::bad_method).category() ? 400 : 0;
}

http::response<http::empty_body> head_of(const HttpResponse& response, unsigned version, bool keep_alive) {
  http::response<http::empty_body> head{http::int_to_status(static_cast<unsigned>(response.status)), version};
  head.set(http::field::content_type, response.type);
  head.set(http::field::cache_control, "no-store");
  for (const auto& [name, value] : guarding_headers(response.file.has_value())) head.set(name, value);
  for (const auto& [name, value] : response.headers) head.set(name, value);
  head.content_length(response.size());
  head.keep_alive(keep_alive);
  return head;
}

/// Whether the body went out as it was announced.
net::awaitable<bool> send_body(beast::tcp_stream& stream, const HttpResponse& response, const ServerLimits& limits) {
  error_code error;
  if (!response.file) {
    co_await net::async_write(stream, net::buffer(response.body), completion(error));
    co_return !error;
  }
  std::vector<char> chunk(static_cast<std::size_t>(std::min<std::uint64_t>(kChunkBytes, response.file->size)));
  for (std::uint64_t sent = 0; sent < response.file->size;) {
    const auto wanted = static_cast<std::size_t>(std::min<std::uint64_t>(chunk.size(), response.file->size - sent));
    const std::size_t count = response.file->file->read_at(response.file->offset + sent, {chunk.data(), wanted});
    if (count == 0) co_return false;  // it became shorter
    stream.expires_after(std::chrono::seconds(limits.idle_s));
    co_await net::async_write(stream, net::buffer(chunk.data(), count), completion(error));
    if (error) co_return false;
    sent += count;
  }
  co_return true;
}

net::awaitable<bool> send(beast::tcp_stream& stream, const HttpResponse& response, const ServerLimits& limits,
                          unsigned version, bool keep_alive, bool head_only) {
  error_code error;
  stream.expires_after(std::chrono::seconds(limits.idle_s));
  const auto head = head_of(response, version, keep_alive);
  http::response_serializer<http::empty_body> serializer(head);
  co_await http::async_write_header(stream, serializer, completion(error));
  if (error) co_return false;
  if (head_only) co_return true;
  const bool whole = co_await send_body(stream, response, limits);
  co_return whole;
}

using Socket = websocket::stream<beast::tcp_stream>;

/// Closes a socket when its writer ends, in whatever way: its reader then ends, too.
class Closing {
 public:
  explicit Closing(std::shared_ptr<Socket> socket) : socket_(std::move(socket)) {}
  ~Closing() { beast::get_lowest_layer(*socket_).close(); }
  Closing(const Closing&) = delete;
  Closing& operator=(const Closing&) = delete;

 private:
  std::shared_ptr<Socket> socket_;
};

/// Reads, and throws away, what a client says: that it closes shows here.
net::awaitable<void> listen_to(std::shared_ptr<Socket> socket, std::shared_ptr<bool> open) {
  error_code error;
  beast::flat_buffer buffer;
  while (!error) {
    buffer.clear();
    co_await socket->async_read(buffer, completion(error));
  }
  *open = false;
}

/// Sends what changes on the board until the client goes.
net::awaitable<void> send_events(beast::tcp_stream stream, http::request<http::string_body> message,
                                 std::shared_ptr<Shared> shared) {
  error_code error;
  std::uint64_t number = asked_since(std::string(message.target())), journal_change = 0;
  stream.expires_never();  // WebSockets have times of their own
  auto socket = std::make_shared<Socket>(std::move(stream));
  const Closing closing(socket);
  socket->set_option(websocket::stream_base::timeout::suggested(beast::role_type::server));
  socket->read_message_max(1024);
  co_await socket->async_accept(message, completion(error));
  if (error) co_return;
  socket->text(true);
  auto open = std::make_shared<bool>(true);
  const auto executor = co_await net::this_coro::executor;
  net::co_spawn(executor, listen_to(socket, open), net::detached);
  net::steady_timer timer(executor);
  bool first = true;
  while (*open && !error) {
    const JobChanges changes = shared->site.board.since(number);
    const JournalChanges journals = shared->site.journals->since(journal_change, shared->site.roots);
    if (first || changes.number != number || !journals.grown.empty()) {
      number = changes.number;
      journal_change = journals.change;
      first = false;
      const std::string text = changes_json(changes, journals.grown);
      co_await socket->async_write(net::buffer(text), completion(error));
    }
    timer.expires_after(kEventInterval);
    error_code ignored;
    if (!error) co_await timer.async_wait(completion(ignored));
  }
}

bool wants_events(const http::request<http::string_body>& message) {
  const std::string_view target(message.target().data(), message.target().size());
  return websocket::is_upgrade(message) && target.substr(0, target.find('?')) == kEventsPath;
}

/// Reads on for a moment what was under way: a connection closed over unread bytes takes the last answer with it.
net::awaitable<void> close_gently(beast::tcp_stream& stream) {
  error_code error;
  stream.socket().shutdown(tcp::socket::shutdown_send, error);
  std::vector<char> bytes(16 * 1024);
  stream.expires_after(kLinger);
  for (std::size_t total = 0; !error && total < kMostUnread;)
    total += co_await stream.async_read_some(net::buffer(bytes), completion(error));
}

net::awaitable<void> serve_connection(tcp::socket accepted, std::shared_ptr<Shared> shared,
                                      [[maybe_unused]] std::shared_ptr<const Seat> seat) {
  const ServerLimits& limits = shared->limits;
  beast::tcp_stream stream(std::move(accepted));
  beast::flat_buffer buffer(static_cast<std::size_t>(limits.header_bytes) + limits.body_bytes);
  while (true) {
    error_code error;
    http::request_parser<http::string_body> parser;
    parser.header_limit(static_cast<std::uint32_t>(limits.header_bytes));
    parser.body_limit(static_cast<std::uint64_t>(limits.body_bytes));
    stream.expires_after(std::chrono::seconds(limits.idle_s));
    co_await http::async_read(stream, buffer, parser, completion(error));
    if (error) {
      const HttpResponse response = error_answer(status_of(error), "the request cannot be read");
      if (response.status != 0) co_await send(stream, response, limits, 11, false, false);
      break;
    }
    auto message = parser.release();
    const unsigned version = message.version();
    const bool head_only = message.method() == http::verb::head, events = wants_events(message);
    const HttpRequest request = plain(message);
    HttpResponse response;
    if (events) {
      auto refused = shared->site.access.refusal(request);
      if (!refused) {
        co_await send_events(std::move(stream), std::move(message), shared);
        co_return;
      }
      response = std::move(*refused);
    } else {
      response = answer_guarded(request, shared->site);
    }
    // Who may not come in does not keep a seat.
    const bool keep_alive = message.keep_alive() && response.status != 401 && response.status != 403;
    const bool sent = co_await send(stream, response, limits, version, keep_alive, head_only);
    if (!sent || !keep_alive) break;
  }
  co_await close_gently(stream);
}

ServerAddress address_of(net::ip::address address) {
  if (address.is_v6() && address.to_v6().is_v4_mapped())
    address = net::ip::make_address_v4(net::ip::v4_mapped, address.to_v6());
  const std::string text = address.to_string();
  return {text.substr(0, text.find('%')), address.is_loopback(), address.is_unspecified()};
}

net::awaitable<void> accept_all(net::io_context& context, tcp::acceptor& acceptor, std::shared_ptr<Shared> shared) {
  while (acceptor.is_open()) {
    error_code error;
    const auto strand = net::make_strand(context);
    tcp::socket socket(strand);
    co_await acceptor.async_accept(socket, completion(error));
    if (error) {  // out of descriptors, perhaps: not at once again
      net::steady_timer timer(context, kEventInterval);
      co_await timer.async_wait(completion(error));
      continue;
    }
    if (shared->connections >= shared->limits.connections) continue;  // closed by its end
    socket.set_option(tcp::no_delay(true), error);                    // head and body go out one after the other
    net::co_spawn(strand, serve_connection(std::move(socket), shared, std::make_shared<const Seat>(shared)),
                  net::detached);
  }
}

}  // namespace

struct Server::State {
  net::io_context context{kIoThreads};
  tcp::acceptor acceptor{context};
  ServerLimits limits;
  ServerAddress address;
  int port = 0;
};

Server::Server() : state_(std::make_unique<State>()) {}
Server::Server(Server&&) noexcept = default;
Server::~Server() = default;
int Server::port() const { return state_->port; }
const ServerAddress& Server::address() const { return state_->address; }

Result<Server> Server::listen(const std::string& address, int port, const ServerLimits& limits) {
  error_code error;
  const auto parsed = net::ip::make_address(address, error);
  if (error)
    return fail(Errc::kBadInput, "\"" + address + "\" is no address such as 127.0.0.1, 0.0.0.0 or ::1",
                {"listen"_option});
  Server server;
  tcp::acceptor& acceptor = server.state_->acceptor;
  const tcp::endpoint endpoint(parsed, static_cast<std::uint16_t>(port));
  acceptor.open(endpoint.protocol(), error);
  if (!error) ::fcntl(acceptor.native_handle(), F_SETFD, FD_CLOEXEC);  // the port is not for programs started here
  if (!error) acceptor.set_option(net::socket_base::reuse_address(true), error);
  if (!error) acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(net::socket_base::max_listen_connections, error);
  if (error)
    return fail(Errc::kBadInput,
                "port " + std::to_string(port) + " of " + address + " cannot be had: " + error.message(),
                {"port"_option});
  server.state_->port = acceptor.local_endpoint().port();
  server.state_->address = address_of(acceptor.local_endpoint().address());
  server.state_->limits = limits;
  return server;
}

void Server::run(Site& site, std::stop_token stop) {
  net::io_context& context = state_->context;
  auto shared = std::make_shared<Shared>(state_->limits, site);
  net::co_spawn(context, accept_all(context, state_->acceptor, shared), net::detached);
  const std::stop_callback on_stop(stop, [&context] { context.stop(); });
  std::vector<std::jthread> threads;
  for (int i = 1; i < kIoThreads; ++i) threads.emplace_back([&context] { context.run(); });
  context.run();
}

}  // namespace collinea
