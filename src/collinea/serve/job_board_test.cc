// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/job_board.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

namespace collinea {
namespace {

JobRequest request_named(const std::string& name) { return {{"id of " + name, name, "/" + name}, Step::kDetect}; }

JobStatus status_of(const JobBoard& board, std::uint64_t id) {
  for (const JobStatus& status : board.since(0).jobs)
    if (status.id == id) return status;
  return {};
}

// Until a job is over, or in work.
JobStatus wait_for(const JobBoard& board, std::uint64_t id, bool in_work = false) {
  while (true) {
    const JobStatus status = status_of(board, id);
    if (status.over() || (in_work && status.state == JobState::kRunning)) return status;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

Result<std::string> until_stopped(const JobRequest&, const collinea::Run& run) {
  while (!run.stopped()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return fail(Errc::kCancelled, "stopped");
}

TEST(JobBoard, JobsAreDoneInTheirOrderOneAtATime) {
  std::atomic<int> in_work = 0, most = 0;
  std::vector<std::string> order;  // written by one job at a time, if the board keeps its promise
  JobBoard board(
      [&](const JobRequest& request, const collinea::Run&) -> Result<std::string> {
        most = std::max<int>(most, ++in_work);
        order.push_back(request.project.name);
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
        --in_work;
        return std::string("[]");
      },
      {});
  std::uint64_t last = 0;
  for (const char* name : {"a", "b", "a", "c"}) last = *board.add(request_named(name));
  EXPECT_EQ(wait_for(board, last).state, JobState::kDone);
  EXPECT_EQ(order, (std::vector<std::string>{"a", "b", "a", "c"}));
  EXPECT_EQ(most, 1);
}

TEST(JobBoard, ProgressLogAndFindingsAreKept) {
  std::vector<std::string> console;
  std::vector<std::pair<std::string, double>> shown;
  JobBoard board(
      [](const JobRequest&, const collinea::Run& run) -> Result<std::string> {
        run.say("begins");
        run.report("detect", 0.5);
        run.say(std::string(2 * JobBoard::kLongestLine, 'x'));
        return std::string("[1]");
      },
      {.progress = [&](std::string_view stage, double done) { shown.emplace_back(stage, done); },
       .log = [&](std::string_view line) { console.emplace_back(line); }});
  const auto id = board.add(request_named("a"));
  ASSERT_TRUE(id);
  const JobStatus status = wait_for(board, *id);
  EXPECT_EQ(status.state, JobState::kDone);
  EXPECT_EQ(status.stage, "detect");
  EXPECT_EQ(status.done, 0.5);
  EXPECT_EQ(status.findings, "[1]");
  EXPECT_EQ(status.project, "id of a");
  const JobChanges all = board.since(0);
  ASSERT_EQ(all.lines.size(), 2u);
  EXPECT_EQ(all.lines[0].text, "begins");
  EXPECT_EQ(all.lines[1].text.size(), JobBoard::kLongestLine);
  EXPECT_EQ(console, (std::vector<std::string>{"begins", all.lines[1].text}));
  EXPECT_EQ(shown, (std::vector<std::pair<std::string, double>>{{"detect", 0.5}}));
}

TEST(JobBoard, WorkHasTheThreadsOfTheBoard) {
  std::atomic<int> threads = 0;
  JobBoard board(
      [&](const JobRequest&, const collinea::Run& run) -> Result<std::string> {
        threads = run.threads;
        return std::string("[]");
      },
      {.threads = 3});
  wait_for(board, *board.add(request_named("a")));
  EXPECT_EQ(threads, 3);
}

TEST(JobBoard, TheOldestLinesOfTheLogAreForgotten) {
  JobBoard board(
      [](const JobRequest&, const collinea::Run& run) -> Result<std::string> {
        for (std::size_t i = 0; i < JobBoard::kMostLines + 10; ++i) run.say(std::to_string(i));
        return std::string("[]");
      },
      {});
  wait_for(board, *board.add(request_named("a")));
  const JobChanges all = board.since(0);
  ASSERT_EQ(all.lines.size(), JobBoard::kMostLines);
  EXPECT_EQ(all.lines.front().text, "10");
  EXPECT_EQ(all.lines.back().text, std::to_string(JobBoard::kMostLines + 9));
}

// Also of a job that reports nothing.
TEST(JobBoard, TheTimeOfAJobInWorkIsThatOfTheQuestion) {
  JobBoard board(until_stopped, {});
  const std::uint64_t id = *board.add(request_named("a"));
  const double first_s = wait_for(board, id, true).elapsed_s;
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  EXPECT_GE(status_of(board, id).elapsed_s, first_s + 0.001);
}

TEST(JobBoard, AFailureNamesItsOptions) {
  JobBoard board(
      [](const JobRequest&, const collinea::Run&) -> Result<std::string> {
        return fail(Errc::kBadInput, "which site?", {"area"_option});
      },
      {});
  const std::uint64_t id = *board.add(request_named("a"));
  EXPECT_EQ(wait_for(board, id).error, "which site? (option area)");
  EXPECT_EQ(board.since(0).lines.at(0).text, "which site? (option area)");
}

TEST(JobBoard, OnlyWhatChangedComesAgain) {
  JobBoard board(
      [](const JobRequest&, const collinea::Run& run) -> Result<std::string> {
        run.say("line");
        return std::string("[]");
      },
      {});
  wait_for(board, *board.add(request_named("a")));
  const JobChanges first = board.since(0);
  EXPECT_EQ(first.jobs.size(), 1u);
  const JobChanges none = board.since(first.number);
  EXPECT_EQ(none.number, first.number);
  EXPECT_TRUE(none.jobs.empty());
  EXPECT_TRUE(none.lines.empty());
  const auto second = board.add(request_named("b"));
  wait_for(board, *second);
  const JobChanges changes = board.since(first.number);
  ASSERT_EQ(changes.jobs.size(), 1u);
  EXPECT_EQ(changes.jobs[0].id, *second);
  EXPECT_EQ(changes.lines.size(), 1u);
}

TEST(JobBoard, JobsStopWaitingOrInWork) {
  JobBoard board(until_stopped, {});
  const std::uint64_t first = *board.add(request_named("a")), second = *board.add(request_named("b"));
  wait_for(board, first, true);
  EXPECT_TRUE(board.stop(second));
  EXPECT_EQ(status_of(board, second).state, JobState::kStopped);
  EXPECT_TRUE(board.stop(first));
  EXPECT_EQ(wait_for(board, first).state, JobState::kStopped);
  EXPECT_FALSE(board.stop(first));
  EXPECT_FALSE(board.stop(77));
}

TEST(JobBoard, AFailureIsOfOneJobAlone) {
  JobBoard board(
      [](const JobRequest& request, const collinea::Run&) -> Result<std::string> {
        if (request.project.name == "bad") return fail(Errc::kBadInput, "no photographs");
        if (request.project.name == "defect") throw std::logic_error("broken promise");
        if (request.project.name == "odd") throw 7;
        return std::string("[]");
      },
      {});
  const std::uint64_t bad = *board.add(request_named("bad")), defect = *board.add(request_named("defect")),
                      odd = *board.add(request_named("odd")), good = *board.add(request_named("good"));
  EXPECT_EQ(wait_for(board, good).state, JobState::kDone);
  EXPECT_EQ(status_of(board, bad).state, JobState::kFailed);
  EXPECT_EQ(status_of(board, bad).error, "no photographs");
  EXPECT_EQ(status_of(board, defect).state, JobState::kFailed);
  EXPECT_EQ(status_of(board, odd).state, JobState::kFailed);
  EXPECT_NE(status_of(board, defect).error.find("broken promise"), std::string::npos);
}

TEST(JobBoard, TheQueueIsBounded) {
  JobBoard board(until_stopped, {});
  wait_for(board, *board.add(request_named("a")), true);
  for (std::size_t i = 0; i < JobBoard::kMostWaiting; ++i) EXPECT_TRUE(board.add(request_named("b")));
  EXPECT_FALSE(board.add(request_named("c")));
}  // and the end of the board stops the one in work

TEST(JobBoard, OldJobsAreForgotten) {
  JobBoard board([](const JobRequest&, const collinea::Run&) -> Result<std::string> { return std::string("[]"); }, {});
  std::uint64_t last = 0;
  for (std::size_t i = 0; i < JobBoard::kMostJobs + 10; ++i) {
    last = *board.add(request_named("a"));
    wait_for(board, last);
  }
  const JobChanges all = board.since(0);
  EXPECT_EQ(all.jobs.size(), JobBoard::kMostJobs);
  EXPECT_EQ(all.jobs.back().id, last);
}

}  // namespace
}  // namespace collinea
