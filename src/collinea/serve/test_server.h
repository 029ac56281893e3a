// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/project/settings.h"
#include "collinea/serve/server.h"
#include "collinea/serve/test_client.h"

namespace collinea {

/// Work that lasts until it is stopped where a report is asked for.
inline Result<std::string> fake_work(const JobRequest& request, const collinea::Run& run) {
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
      const testing::Answer answer = ask("GET " + access_->link() + " HTTP/1.1\r\nHost: " + host() + "\r\n\r\n");
      EXPECT_EQ(answer.status, 200);
      const std::string set = answer.header("Set-Cookie");
      cookie_ = set.substr(0, set.find(';'));
    }
    return cookie_;
  }
  [[nodiscard]] testing::Answer ask(const std::string& text, bool has_body = true) const {
    testing::Connection connection(port());
    connection.send(text);
    return connection.read_answer(has_body).value_or(testing::Answer{});
  }
  std::string head(const std::string& method, const std::string& target) {
    return method + " " + target + " HTTP/1.1\r\nHost: " + host() + "\r\nCookie: " + cookie() + "\r\n";
  }
  testing::Answer fetch(const std::string& target, const std::string& headers = "") {
    return ask(head("GET", target) + headers + "\r\n");
  }
  testing::Answer post(const std::string& target, const std::string& body,
                       const std::string& type = "application/json") {
    return ask(head("POST", target) + "Content-Type: " + type + "\r\nContent-Length: " + std::to_string(body.size()) +
               "\r\n\r\n" + body);
  }
  /// "/api/projects/ID".
  std::string project() {
    return "/api/projects/" + nlohmann::json::parse(fetch("/api/projects").body).at(0).at("id").get<std::string>();
  }

  TestFolder folder_;
  std::unique_ptr<Server> server_;
  std::unique_ptr<Access> access_;
  std::unique_ptr<JobBoard> board_;
  std::unique_ptr<Site> site_;
  std::jthread thread_;
  std::string cookie_;
};

}  // namespace collinea
