// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/server.h"

#include <fcntl.h>
#include <gtest/gtest.h>

#include <map>
#include <regex>
#include <set>

#include "collinea/serve/test_odd_requests.h"
#include "collinea/serve/test_server.h"

namespace collinea {
namespace {

using nlohmann::json;
using testing::Answer;
using testing::Connection;

TEST_F(ServerTest, OnlyTheLinkLetsIn) {
  const std::string good = "Host: " + host() + "\r\n";
  for (const char* target :
       {"/", "/icon.svg", "/assets/x.js", "/api/projects", "/api/options", "/nothing", "/?token=", "/?token=00"})
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

TEST_F(ServerTest, RefusalsAreJson) {
  const std::string good = "Host: " + host() + "\r\n";
  const Answer answers[] = {ask("GET / HTTP/1.1\r\n" + good + "\r\n"),
                            ask("GET / HTTP/1.1\r\nHost: evil.example\r\n\r\n"), ask("no HTTP at all\r\n\r\n"),
                            fetch("/", "X-Long: " + std::string(20'000, 'x') + "\r\n"),
                            post(project() + "/jobs", std::string(600'000, ' '))};
  const int wanted[] = {401, 403, 400, 431, 413};
  for (std::size_t i = 0; i < std::size(wanted); ++i) {
    EXPECT_EQ(answers[i].status, wanted[i]) << i;
    EXPECT_EQ(answers[i].header("Content-Type"), "application/json") << i;
    const json body = json::parse(answers[i].body, nullptr, false);
    EXPECT_TRUE(body.is_object() && body.contains("error")) << answers[i].body;
  }
}

// Each connection is one of few.
TEST_F(ServerTest, WhoMayNotComeInIsLeft) {
  for (const std::string& who : {host(), std::string("evil.example")}) {
    Connection connection(port());
    connection.send("GET / HTTP/1.1\r\nHost: " + who + "\r\n\r\n");
    const auto refused = connection.read_answer();
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->header("Connection"), "close");
    EXPECT_EQ(connection.read_all(), "");
  }
}

TEST_F(ServerTest, ThePageIsHereAndGuarded) {
  const Answer page = fetch("/");
  EXPECT_EQ(page.status, 200);
  EXPECT_EQ(page.header("Content-Type"), "text/html; charset=utf-8");
  EXPECT_EQ(page.header("Cache-Control"), "no-cache");
  EXPECT_EQ(page.body.find("http"), std::string::npos);  // nothing comes from elsewhere
  EXPECT_EQ(page.header("X-Content-Type-Options"), "nosniff");
  EXPECT_NE(page.header("Content-Security-Policy")
                .find("default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self';"),
            std::string::npos);
  EXPECT_EQ(post("/", "{}").status, 405);
  EXPECT_NE(fetch(project() + "/files/report/report.html").header("Content-Security-Policy").find("sandbox;"),
            std::string::npos);
}

// The files that the page names, each with its type, compressed for those who can read that.
TEST_F(ServerTest, WhatThePageNamesIsHere) {
  const std::string page = fetch("/").body;
  const std::regex names("(?:src|href)=\"(/[^\"]+)\"");
  const std::map<std::string, std::string> types = {
      {".js", "text/javascript; charset=utf-8"}, {".css", "text/css; charset=utf-8"}, {".svg", "image/svg+xml"}};
  std::set<std::string> seen;
  for (std::sregex_iterator name(page.begin(), page.end(), names), end; name != end; ++name) {
    const std::string target = (*name)[1];
    const std::string kind = std::filesystem::path(target).extension();
    const Answer plain = fetch(target), zipped = fetch(target, "Accept-Encoding: gzip\r\n");
    EXPECT_EQ(plain.status, 200) << target;
    ASSERT_TRUE(types.contains(kind)) << target;
    EXPECT_EQ(plain.header("Content-Type"), types.at(kind));
    EXPECT_EQ(plain.header("Content-Encoding"), "");
    EXPECT_EQ(plain.header("Vary"), "Accept-Encoding");
    if (kind == ".svg") continue;
    EXPECT_NE(plain.header("Cache-Control").find("immutable"), std::string::npos) << target;
    EXPECT_EQ(zipped.header("Content-Encoding"), "gzip") << target;
    EXPECT_LT(zipped.body.size(), plain.body.size()) << target;
    EXPECT_TRUE(zipped.body.starts_with("\x1f\x8b")) << target;
    seen.insert(kind);
  }
  if (page.find("without its page") != std::string::npos) GTEST_SKIP() << "built with COLLINEA_PAGE=OFF";
  EXPECT_EQ(seen, (std::set<std::string>{".css", ".js"}));
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
  for (const char* target :
       {"/nothing", "/icon.svg/x", "/assets", "/assets/", "/assets/..", "/assets/none.js", "/api", "/api/",
        "/api/projects/7", "/api/projects/", "/api/projects/../x", "/api/nothing", "/favicon.ico"})
    EXPECT_EQ(fetch(target).status, 404) << target;
  EXPECT_EQ(fetch("/%zz").status, 400);
  EXPECT_EQ(ask(head("DELETE", "/api/projects") + "\r\n").status, 405);
  EXPECT_EQ(post("/api/projects", "{}").status, 405);
  EXPECT_EQ(fetch(project() + "/jobs").status, 405);
}

TEST_F(ServerTest, WhatIsTooLargeIsRefused) {
  EXPECT_EQ(fetch("/", "X-Long: " + std::string(20'000, 'x') + "\r\n").status, 431);
  EXPECT_EQ(post(project() + "/jobs", std::string(600'000, ' ')).status, 413);
  EXPECT_EQ(ask("no HTTP at all\r\n\r\n").status, 400);
}

TEST_F(ServerTest, OneConnectionServesManyRequests) {
  const std::string request = head("GET", "/") + "\r\n";
  Connection connection(port());
  for (int i = 0; i < 3; ++i) {
    connection.send(request);
    EXPECT_EQ(connection.read_answer().value_or(Answer{}).status, 200);
  }
  connection.send(request + request);  // without waiting
  EXPECT_EQ(connection.read_answer().value_or(Answer{}).status, 200);
  EXPECT_EQ(connection.read_answer().value_or(Answer{}).status, 200);
}

TEST_F(ServerTest, ConnectionsAreBounded) {
  stop();
  start({.connections = 2});
  const std::string request = head("GET", "/") + "\r\n";
  const auto open_one = [&] {  // refused as long as one that has ended is still counted
    while (true) {
      auto connection = std::make_unique<Connection>(port());
      connection->send(request);
      if (connection->read_answer()) return connection;
    }
  };
  auto first = open_one(), second = open_one();
  Connection third(port());
  third.send(request);
  EXPECT_EQ(third.read_all(), "");
  first.reset();
  first = open_one();
}

// The server, not the client, ends these; that it does so for their silence shows by a server that is more patient.
TEST_F(ServerTest, WhoSaysNothingMoreIsLeft) {
  stop();
  start({.idle_s = 3600});
  const Connection waits(port());
  auto hasty = Server::listen("127.0.0.1", 0, {.idle_s = 1});
  ASSERT_TRUE(hasty) << hasty.error().message;
  const std::jthread thread([&](std::stop_token end) { hasty->run(*site_, std::move(end)); });
  Connection silent(hasty->port()), half(hasty->port());
  half.send("GET / HTTP/1.1\r\nHost:");
  EXPECT_EQ(silent.read_all(), "");
  EXPECT_EQ(half.read_all(), "");
  EXPECT_TRUE(waits.open());
}

// A browser started with the link would hold the port otherwise.
TEST_F(ServerTest, ProgramsStartedHereDoNotGetThePort) {
  int listening = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int descriptor = std::stoi(entry.path().filename().string());
    int listens = 0;
    socklen_t size = sizeof listens;
    if (::getsockopt(descriptor, SOL_SOCKET, SO_ACCEPTCONN, &listens, &size) != 0 || listens == 0) continue;
    ++listening;
    EXPECT_NE(::fcntl(descriptor, F_GETFD) & FD_CLOEXEC, 0);
  }
  EXPECT_EQ(listening, 1);
}

TEST_F(ServerTest, APortIsTakenOnce) {
  EXPECT_FALSE(Server::listen("127.0.0.1", port()));
  EXPECT_FALSE(Server::listen("nowhere", 0));
}

// Each is answered in HTTP, or its connection is closed; and the server goes on.
TEST_F(ServerTest, OddRequestsDoNoHarm) {
  testing::OddRequests requests(host(), cookie(), project());
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
