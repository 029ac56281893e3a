// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/server.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/project/settings.h"
#include "collinea/serve/test_client.h"

namespace collinea {
namespace {

using nlohmann::json;
using testing::Answer;
using testing::Connection;

Result<std::string> fake_work(const JobRequest& request, const collinea::Run& run) {
  run.say("begins");
  run.report("detect", 0.25);
  if (request.step == Step::kReport)  // one that lasts
    while (!run.stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  if (run.stopped()) return fail(Errc::kCancelled, "stopped");
  return std::string(R"([{"what": "A finding."}])");
}

/// A server of one project, at a port that was free.
class ServerTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const std::filesystem::path project = folder_ / "village";
    std::filesystem::create_directories(project / "products");
    ASSERT_TRUE(write_settings(project, {}));
    ASSERT_TRUE(write_file(project / "products" / "dsm.tif", "0123456789"));
    ASSERT_TRUE(write_file(project / "report" / "report.html", "<p>report"));
    ASSERT_TRUE(write_file(folder_ / "secret", "secret"));
    std::filesystem::create_symlink(folder_ / "secret", project / "products" / "secret");
    start({});
  }
  void TearDown() override { stop(); }

  void start(const ServerLimits& limits) {
    auto server = Server::listen("127.0.0.1", 0, limits);
    ASSERT_TRUE(server) << server.error().message;
    server_ = std::make_unique<Server>(std::move(*server));
    access_ = std::make_unique<Access>(ServerNames{.port = server_->port()});
    board_ = std::make_unique<JobBoard>(fake_work, collinea::Run{});
    site_ = std::make_unique<Site>(Site{{folder_ / ""}, *access_, *board_});
    thread_ = std::jthread([this](std::stop_token end) { server_->run(*site_, std::move(end)); });
    cookie_.clear();
  }
  void stop() {
    thread_ = {};
    server_.reset();
  }

  [[nodiscard]] int port() const { return server_->port(); }
  [[nodiscard]] std::string host() const { return "127.0.0.1:" + std::to_string(port()); }
  /// The cookie, for which a link is used up once.
  const std::string& cookie() {
    if (cookie_.empty()) {
      const Answer answer = ask("GET " + access_->link() + " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
      EXPECT_EQ(answer.status, 200);
      const std::string set = answer.header("Set-Cookie");
      cookie_ = set.substr(0, set.find(';'));
    }
    return cookie_;
  }
  [[nodiscard]] Answer ask(const std::string& text, bool has_body = true) const {
    Connection connection(port());
    connection.send(text);
    return connection.read_answer(has_body).value_or(Answer{});
  }
  std::string head(const std::string& method, const std::string& target) {
    return method + " " + target + " HTTP/1.1\r\nHost: " + host() + "\r\nCookie: " + cookie() + "\r\n";
  }
  Answer fetch(const std::string& target, const std::string& headers = "") {
    return ask(head("GET", target) + headers + "\r\n");
  }
  Answer post(const std::string& target, const std::string& body, const std::string& type = "application/json") {
    return ask(head("POST", target) + "Content-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) +
               "\r\n\r\n" + body);
  }
  /// "/api/projects/ID".
  std::string project() {
    return "/api/projects/" + json::parse(fetch("/api/projects").body).at(0).at("id").get<std::string>();
  }

  TestFolder folder_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Access> access_;
  std::unique_ptr<JobBoard> board_;
  std::unique_ptr<Site> site_;
  std::jthread thread_;
  std::string cookie_;
};

TEST_F(ServerTest, OnlyTheLinkLetsIn) {
  const std::string good = "Host: " + host() + "\r\n";
  for (const char* target : {"/", "/page.js", "/api/projects", "/api/options", "/nothing", "/?token=", "/?token=00"})
    EXPECT_EQ(ask("GET " + std::string(target) + " HTTP/1.1\r\n" + good + "\r\n").status, 401) << target;
  const std::string link = access_->link();
  EXPECT_EQ(ask("GET " + link + " HTTP/1.1\r\nHost: evil.example\r\n\r\n").status, 403);
  EXPECT_EQ(ask("GET " + link + " HTTP/1.1\r\n" + good + "Origin: http://evil.example\r\n\r\n").status, 403);
  EXPECT_EQ(ask("GET " + link + " HTTP/1.1\r\n\r\n").status, 403);
  EXPECT_EQ(ask("POST " + link + " HTTP/1.1\r\n" + good + "Content-Length: 0\r\n\r\n").status, 401);
  EXPECT_FALSE(cookie().empty());
  EXPECT_EQ(ask("GET " + link + " HTTP/1.1\r\n" + good + "\r\n").status, 401);  // it serves once
  EXPECT_EQ(fetch("/").status, 200);
  EXPECT_EQ(fetch("/", "Origin: http://" + host() + "\r\n").status, 200);
  EXPECT_EQ(fetch("/", "Origin: http://evil.example\r\n").status, 403);
  EXPECT_EQ(fetch("/", "Host: " + host() + "\r\n").status, 403);  // two of them
}

TEST_F(ServerTest, ThePageIsHereAndGuarded) {
  const Answer page = fetch("/");
  EXPECT_NE(page.body.find("<script src=\"/page.js\">"), std::string::npos);
  EXPECT_EQ(page.body.find("http"), std::string::npos);  // nothing comes from elsewhere
  EXPECT_EQ(page.header("X-Content-Type-Options"), "nosniff");
  EXPECT_NE(page.header("Content-Security-Policy").find("default-src 'none'; script-src 'self'"), std::string::npos);
  EXPECT_EQ(fetch("/page.js").header("Content-Type"), "text/javascript; charset=utf-8");
  EXPECT_GT(fetch("/page.js").body.size(), 1000u);
  EXPECT_EQ(fetch("/page.css").header("Content-Type"), "text/css; charset=utf-8");
  EXPECT_NE(fetch(project() + "/files/report/report.html").header("Content-Security-Policy").find("sandbox;"),
            std::string::npos);
}

TEST_F(ServerTest, ProjectsOptionsAndSettingsAreJson) {
  const json projects = json::parse(fetch("/api/projects").body);
  ASSERT_EQ(projects.size(), 1u);
  EXPECT_EQ(projects[0].at("name"), "village");
  const json shown = json::parse(fetch(project()).body);
  EXPECT_EQ(shown.at("files").at(0).at("path"), "products/dsm.tif");
  EXPECT_EQ(json::parse(fetch(project() + "/settings").body).at("seed"), 1);
  EXPECT_GT(json::parse(fetch("/api/options").body).size(), 10u);
  EXPECT_TRUE(json::parse(fetch("/api/jobs").body).at("jobs").empty());
}

TEST_F(ServerTest, FilesComeWholeAndInParts) {
  const std::string file = project() + "/files/products/dsm.tif";
  const Answer whole = fetch(file);
  EXPECT_EQ(whole.status, 200);
  EXPECT_EQ(whole.body, "0123456789");
  EXPECT_EQ(whole.header("Content-Type"), "image/tiff");
  EXPECT_EQ(whole.header("Accept-Ranges"), "bytes");
  const Answer part = fetch(file, "Range: bytes=2-4\r\n");
  EXPECT_EQ(part.status, 206);
  EXPECT_EQ(part.body, "234");
  EXPECT_EQ(part.header("Content-Range"), "bytes 2-4/10");
  EXPECT_EQ(fetch(file, "Range: bytes=-3\r\n").body, "789");
  EXPECT_EQ(fetch(file, "Range: bytes=8-\r\n").body, "89");
  for (const char* range : {"bytes=10-", "bytes=0-1,4-5", "bytes=5-4", "bytes=-0"}) {
    const Answer none = fetch(file, "Range: " + std::string(range) + "\r\n");
    EXPECT_EQ(none.status, 416) << range;
    EXPECT_EQ(none.header("Content-Range"), "bytes */10") << range;
  }
  const std::string tag = whole.header("ETag");
  EXPECT_EQ(fetch(file, "Range: bytes=2-4\r\nIf-Range: " + tag + "\r\n").status, 206);
  EXPECT_EQ(fetch(file, "Range: bytes=2-4\r\nIf-Range: \"other\"\r\n").body, "0123456789");
  const Answer head_only = ask(head("HEAD", file) + "\r\n", false);
  EXPECT_EQ(head_only.status, 200);
  EXPECT_EQ(head_only.header("Content-Length"), "10");
}

// More than one chunk of what is sent.
TEST_F(ServerTest, LargeFilesComeWhole) {
  std::string bytes(3'000'001, ' ');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 2654435761u >> 13);
  ASSERT_TRUE(write_file(folder_ / "village" / "products" / "cloud.laz", bytes));
  EXPECT_TRUE(fetch(project() + "/files/products/cloud.laz").body == bytes);
  const Answer part = fetch(project() + "/files/products/cloud.laz", "Range: bytes=1000000-2999999\r\n");
  EXPECT_TRUE(part.body == bytes.substr(1'000'000, 2'000'000));
}

TEST_F(ServerTest, NothingElseIsThere) {
  const std::string files = project() + "/files/";
  for (const char* path : {"products/missing", "products/secret", "products/../project.json",
                           "products/%2e%2e/block.db", "../../secret", "%2e%2e/%2e%2e/secret", "products%2fdsm.tif",
                           "/etc/passwd", "project.json", "products//dsm.tif", "products", ""})
    EXPECT_EQ(fetch(files + path).status, 404) << path;
  for (const char* target : {"/nothing", "/page.js/x", "/api", "/api/", "/api/projects/7", "/api/projects/",
                             "/api/projects/../x", "/api/nothing", "/favicon.ico"})
    EXPECT_EQ(fetch(target).status, 404) << target;
  EXPECT_EQ(fetch("/%zz").status, 400);
  EXPECT_EQ(ask(head("DELETE", "/api/projects") + "\r\n").status, 405);
  EXPECT_EQ(post("/api/projects", "{}").status, 405);
  EXPECT_EQ(fetch(project() + "/jobs").status, 405);
}

TEST_F(ServerTest, WhatIsTooLargeIsRefused) {
  EXPECT_EQ(fetch("/", "X-Long: " + std::string(20'000, 'x') + "\r\n").status, 431);
  EXPECT_EQ(post(project() + "/jobs", std::string(70'000, ' ')).status, 413);
  EXPECT_EQ(ask("no HTTP at all\r\n\r\n").status, 400);
}

TEST_F(ServerTest, OneConnectionServesManyRequests) {
  const std::string request = head("GET", "/page.css") + "\r\n";
  Connection connection(port());
  for (int i = 0; i < 3; ++i) {
    connection.send(request);
    EXPECT_EQ(connection.read_answer().value_or(Answer{}).status, 200);
  }
  connection.send(request + request);  // without waiting
  EXPECT_EQ(connection.read_answer().value_or(Answer{}).status, 200);
  EXPECT_EQ(connection.read_answer().value_or(Answer{}).status, 200);
}

TEST_F(ServerTest, JobsAreAskedForAsJson) {
  const std::string jobs = project() + "/jobs";
  for (const char* wrong : {"", "{", "[]", "{}", R"({"step": "nothing"})", R"({"step": 3})",
                            R"({"step": "detect", "options": {"nothing": {}}})",
                            R"({"step": "detect", "options": {"verify": {"max_error_px": -1}}})"})
    EXPECT_EQ(post(jobs, wrong).status, 400) << wrong;
  const std::string deep = R"({"step": "detect", "options": )" + std::string(30'000, '[') + std::string(30'000, ']');
  EXPECT_EQ(post(jobs, deep + "}").status, 400);
  EXPECT_EQ(post(jobs, R"({"step": "detect"})", "text/plain").status, 415);  // as a form of another site could
  EXPECT_EQ(post("/api/jobs/77/stop", "{}").status, 404);
  EXPECT_EQ(post("/api/jobs/x/stop", "{}").status, 404);
  EXPECT_TRUE(board_->since(0).jobs.empty());
}

// RFC 6455, 1.3.
constexpr const char* kUpgrade =
    "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
    "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";

TEST_F(ServerTest, AJobIsFollowedToItsEnd) {
  Connection events(port());
  events.send(head("GET", "/api/events") + "Origin: http://" + host() + "\r\n" + kUpgrade);
  const auto upgraded = events.read_answer(false);
  ASSERT_TRUE(upgraded);
  ASSERT_EQ(upgraded->status, 101);
  EXPECT_EQ(upgraded->header("Sec-WebSocket-Accept"), "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
  EXPECT_TRUE(json::parse(testing::read_message(events).value_or("{}")).at("jobs").empty());

  const Answer made = post(project() + "/jobs", R"({"step": "report", "options": {"verify": {"max_error_px": 3}}})");
  ASSERT_EQ(made.status, 202) << made.body;
  const int id = json::parse(made.body).at("job");
  json last;
  std::vector<std::string> lines;
  bool asked = false;
  while (last.is_null() || last.at("state") == "queued" || last.at("state") == "running") {
    const auto message = testing::read_message(events);
    ASSERT_TRUE(message);
    const json changes = json::parse(*message);
    for (const json& line : changes.at("log")) lines.push_back(line.at("line"));
    for (const json& job : changes.at("jobs")) last = job;
    if (!asked && !last.is_null() && last.at("stage") == "detect") {
      EXPECT_EQ(last.at("done"), 0.25);
      EXPECT_EQ(last.at("state"), "running");
      EXPECT_TRUE(last.at("left_s").is_number());
      EXPECT_EQ(post("/api/jobs/" + std::to_string(id) + "/stop", "").status, 200);
      asked = true;
    }
  }
  EXPECT_TRUE(asked);
  EXPECT_EQ(last.at("id"), id);
  EXPECT_EQ(last.at("state"), "stopped");
  EXPECT_EQ(lines, (std::vector<std::string>{"begins", "stopped"}));

  ASSERT_EQ(post(project() + "/jobs", R"({"step": "detect"})").status, 202);
  while (last.at("state") != "done") {
    const auto message = testing::read_message(events);
    ASSERT_TRUE(message);
    const json changes = json::parse(*message);
    for (const json& job : changes.at("jobs")) last = job;
  }
  EXPECT_EQ(last.at("findings").at(0).at("what"), "A finding.");
}

TEST_F(ServerTest, EventsAreForThoseWithTheCookie) {
  const std::string start = "GET /api/events HTTP/1.1\r\nHost: " + host() + "\r\n";
  EXPECT_EQ(ask(start + kUpgrade).status, 401);
  EXPECT_EQ(ask(start + "Cookie: " + cookie() + "\r\nOrigin: http://evil.example\r\n" + kUpgrade).status, 403);
  EXPECT_EQ(fetch("/api/events").status, 404);  // no WebSocket
}

TEST_F(ServerTest, ConnectionsAreBounded) {
  stop();
  start({.connections = 2});
  const std::string request = head("GET", "/page.css") + "\r\n";
  const auto open_one = [&] {  // refused as long as one that has ended is still counted
    while (true) {
      auto connection = std::make_unique<Connection>(port());
      connection->send(request);
      if (connection->read_answer()) return connection;
    }
  };
  auto first = open_one(), second = open_one();
  Connection third(port());
  EXPECT_EQ(third.read_all(), "");
  first.reset();
  first = open_one();
}

// The server, not the client, ends these.
TEST_F(ServerTest, WhoSaysNothingMoreIsLeft) {
  stop();
  start({.idle_s = 1});
  Connection silent(port()), half(port());
  half.send("GET / HTTP/1.1\r\nHost:");
  EXPECT_EQ(silent.read_all(), "");
  EXPECT_EQ(half.read_all(), "");
}

TEST_F(ServerTest, APortIsTakenOnce) {
  EXPECT_FALSE(Server::listen("127.0.0.1", port()));
  EXPECT_FALSE(Server::listen("nowhere", 0));
}

/// Requests that are nearly right, and such that are not.
class OddRequests {
 public:
  OddRequests(std::string host, std::string cookie, std::string project)
      : host_(std::move(host)), cookie_(std::move(cookie)), project_(std::move(project)) {}

  std::string next() {
    if (below(10) == 0) return bytes(below(400));
    std::string text = below(3) != 0 ? "GET" : one({"HEAD", "POST", "PUT", "OPTIONS", "get", "", "CONNECT", "PRI"});
    text += " " + target();
    text += " " + (below(4) != 0 ? "HTTP/1.1" : one({"HTTP/1.0", "HTTP/2.0", "HTTP/9", ""}));
    text += "\r\n";
    if (below(8) != 0) text += "Host: " + host_ + "\r\n";
    if (below(8) != 0) text += "Cookie: " + cookie_ + "\r\n";
    for (int i = below(4); i > 0; --i) text += header() + "\r\n";
    text += "\r\n";
    if (below(2) == 0)
      text += one({"{\"step\": \"detect\"}", "{\"step\":", "[[[[[[", "5\r\nhello\r\n0\r\n\r\n"}) + bytes(below(50));
    if (below(3) == 0)
      for (int i = 1 + below(5); i > 0; --i)
        text[static_cast<std::size_t>(below(static_cast<int>(text.size())))] = byte();
    if (below(6) == 0) text.resize(static_cast<std::size_t>(below(static_cast<int>(text.size()))));
    return text;
  }

 private:
  int below(int bound) { return static_cast<int>(random_() % static_cast<unsigned>(std::max(1, bound))); }
  char byte() { return static_cast<char>(below(256)); }
  std::string bytes(int count) {
    std::string text;
    while (count-- > 0) text += byte();
    return text;
  }
  std::string one(std::vector<std::string> choices) {
    return choices[static_cast<std::size_t>(below(static_cast<int>(choices.size())))];
  }
  std::string target() {
    std::string text =
        one({"/", "/page.js", "/api/projects", "/api/options", "/api/jobs", "/api/jobs/1/stop", "/api/events", project_,
             project_ + "/jobs", project_ + "/settings", project_ + "/files/products/dsm.tif",
             project_ + "/files/products/secret", project_ + "/files/../../secret", "//", "*", "http://x/"});
    if (below(3) == 0)
      text += one({"?", "?token=0", "/..", "%2e%2e", "%", "%00", "#", "?since=99999999999999999999", "/"});
    return text;
  }
  std::string header() {
    return one({"Range: bytes=" + one({"0-1", "-1", "5-", "0-0,2-3", "9-1", "-", "18446744073709551616-", "x"}),
                "Content-Length: " + one({"0", "18", "-1", "99999999999999999999", "x", "70000"}),
                "Content-Type: application/json", "Transfer-Encoding: chunked", "Expect: 100-continue",
                "Connection: " + one({"close", "Upgrade", "keep-alive"}), "Upgrade: websocket",
                "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==",
                "Origin: " + one({"null", "http://" + host_, "http://evil.example"}), "If-Range: \"x\"",
                "X: " + bytes(below(300)), std::string(static_cast<std::size_t>(below(30'000)), 'h')});
  }

  std::mt19937 random_{20261127};
  std::string host_, cookie_, project_;
};

// Each is answered in HTTP, or its connection is closed; and the server goes on.
TEST_F(ServerTest, OddRequestsDoNoHarm) {
  OddRequests requests(host(), cookie(), project());
  int answered = 0, well = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::string request = requests.next();
    Connection connection(port());
    ASSERT_TRUE(connection.connected()) << i;
    connection.send(request);
    connection.end_sending();
    const std::string answer = connection.read_all();
    if (answer.empty()) continue;
    ++answered;
    ASSERT_TRUE(answer.starts_with("HTTP/1.")) << answer.substr(0, 100);
    EXPECT_NE(answer[9], '5') << request << "\n" << answer;  // no defect
    EXPECT_EQ(answer.find("secret"), std::string::npos) << request;
    well += answer[9] == '2';
  }
  EXPECT_GT(answered, 300);  // the generator reaches what is behind the parser
  EXPECT_GT(well, 50);
  EXPECT_EQ(fetch("/").status, 200);
}

}  // namespace
}  // namespace collinea
