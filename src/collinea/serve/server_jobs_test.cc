// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/test_server.h"

namespace collinea {
namespace {

using nlohmann::json;
using testing::Answer;
using testing::Connection;

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

TEST_F(ServerTest, EventsBeginBehindANumber) {
  ASSERT_EQ(post(project() + "/jobs", R"({"step": "detect"})").status, 202);
  JobChanges all = board_->since(0);
  for (; all.jobs.empty() || !all.jobs[0].over(); all = board_->since(0))
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const auto first_message = [&](const std::string& query) {
    Connection events(port());
    events.send(head("GET", "/api/events" + query) + kUpgrade);
    EXPECT_EQ(events.read_answer(false).value_or(Answer{}).status, 101);
    return json::parse(testing::read_message(events).value_or("{}"));
  };
  for (const char* from_the_start : {"", "?since=0", "?since=x"}) {
    const json whole = first_message(from_the_start);
    EXPECT_EQ(whole.at("number"), all.number);
    EXPECT_EQ(whole.at("jobs").size(), 1u) << from_the_start;
    EXPECT_EQ(whole.at("log").size(), 1u) << from_the_start;
  }
  const json later = first_message("?since=" + std::to_string(all.lines[0].number));
  EXPECT_EQ(later.at("jobs").size(), 1u);  // which ended behind its line
  EXPECT_TRUE(later.at("log").empty());
  const json none = first_message("?since=" + std::to_string(all.number));
  EXPECT_EQ(none.at("number"), all.number);
  EXPECT_TRUE(none.at("jobs").empty());
}

TEST_F(ServerTest, AFullQueueIsForLater) {
  const std::string jobs = project() + "/jobs", lasting = R"({"step": "report"})";
  ASSERT_EQ(post(jobs, lasting).status, 202);
  while (board_->since(0).jobs.at(0).state != JobState::kRunning)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  for (std::size_t i = 0; i < JobBoard::kMostWaiting; ++i) EXPECT_EQ(post(jobs, lasting).status, 202);
  EXPECT_EQ(post(jobs, lasting).status, 503);
}

TEST_F(ServerTest, EventsAreForThoseWithTheCookie) {
  const std::string start = "GET /api/events HTTP/1.1\r\nHost: " + host() + "\r\n";
  EXPECT_EQ(ask(start + kUpgrade).status, 401);
  EXPECT_EQ(ask(start + "Cookie: " + cookie() + "\r\nOrigin: http://evil.example\r\n" + kUpgrade).status, 403);
  EXPECT_EQ(fetch("/api/events").status, 404);  // no WebSocket
}

}  // namespace
}  // namespace collinea
