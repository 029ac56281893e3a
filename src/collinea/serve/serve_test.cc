// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/serve.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <sstream>
#include <thread>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/serve/internal/open_link.h"

namespace collinea {
namespace {

// What the console shows of a server that ends as soon as it has begun.
Result<std::vector<std::string>> begun_and_ended(const ServeOptions& options, const std::filesystem::path& folder) {
  std::vector<std::string> lines;
  const auto show = [&](std::string_view line) { lines.emplace_back(line); };
  std::stop_source stop;
  stop.request_stop();
  COLLINEA_TRY(serve({folder}, options, {.stop = stop.get_token(), .log = show}, show));
  return lines;
}

/// A variable of the environment, as it was before at its end.
class Variable {
 public:
  Variable(const char* name, const std::string& value) : name_(name) {
    if (const char* before = std::getenv(name)) before_ = before;
    ::setenv(name, value.c_str(), 1);
  }
  ~Variable() { before_ ? ::setenv(name_, before_->c_str(), 1) : ::unsetenv(name_); }
  Variable(const Variable&) = delete;
  Variable& operator=(const Variable&) = delete;

 private:
  const char* name_;
  std::optional<std::string> before_;
};

TEST(Serve, TheLinkLeadsToThisMachine) {
  const TestFolder folder;
  const auto lines = begun_and_ended({.port = 0}, folder / "");
  ASSERT_TRUE(lines) << lines.error().message;
  ASSERT_EQ(lines->size(), 1u);
  EXPECT_NE(lines->front().find("0 projects; open http://127.0.0.1:"), std::string::npos) << lines->front();
  EXPECT_NE(lines->front().find("/?token="), std::string::npos);
}

TEST(Serve, TheLinkIsShownWhereNothingIsLogged) {
  const TestFolder folder;
  std::vector<std::string> shown;
  std::stop_source stop;
  stop.request_stop();
  ASSERT_TRUE(serve({folder / ""}, {.port = 0}, {.stop = stop.get_token()},
                    [&](std::string_view line) { shown.emplace_back(line); }));
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_NE(shown[0].find("/?token="), std::string::npos);
}

TEST(Serve, BeyondThisMachineIsWarnedOf) {
  const TestFolder folder;
  for (const char* address : {"0.0.0.0", "::", "0:0:0:0:0:0:0:0"}) {
    const auto open = begun_and_ended({.port = 0, .listen = address}, folder / "");
    ASSERT_TRUE(open) << open.error().message;
    EXPECT_TRUE(open->front().starts_with("warning:")) << open->front();
    EXPECT_NE(open->at(1).find("open http://127.0.0.1:"), std::string::npos) << open->at(1);
  }
  const std::pair<const char*, const char*> loopback[] = {{"127.0.0.1", "http://127.0.0.1:"},
                                                          {"127.0.0.2", "http://127.0.0.2:"},
                                                          {"::1", "http://[::1]:"},
                                                          {"0:0:0:0:0:0:0:1", "http://[::1]:"},
                                                          {"::ffff:127.0.0.1", "http://127.0.0.1:"}};
  for (const auto& [address, link] : loopback) {
    const auto closed = begun_and_ended({.port = 0, .listen = address}, folder / "");
    ASSERT_TRUE(closed) << closed.error().message;
    EXPECT_NE(closed->front().find(std::string("open ") + link), std::string::npos) << closed->front();
  }
}

// The link can be opened by hand.
TEST(Serve, ABrowserThatCannotBeStartedIsNoEnd) {
  const TestFolder folder;
  {
    const Variable path("PATH", (folder / "").string());
    const auto lines = begun_and_ended({.port = 0, .open = true}, folder / "");
    ASSERT_TRUE(lines) << lines.error().message;
    ASSERT_EQ(lines->size(), 2u);
    EXPECT_TRUE(lines->back().starts_with("warning: xdg-open is missing")) << lines->back();
  }
  const Variable temporary("TMPDIR", (folder / "missing").string());
  const auto lines = begun_and_ended({.port = 0, .open = true}, folder / "");
  ASSERT_TRUE(lines) << lines.error().message;
  ASSERT_EQ(lines->size(), 2u);
  EXPECT_TRUE(lines->back().starts_with("warning: no temporary folder")) << lines->back();
}

// A program in place of the browser's writes down what it was given, and its session.
TEST(Serve, TheBrowserGetsAFileInASessionOfItsOwn) {
  const TestFolder folder;
  const std::filesystem::path said = folder / "said", given = folder / "tmp";
  std::filesystem::create_directories(given);
  ASSERT_TRUE(write_file(folder / "xdg-open", "#!/bin/sh\n{ cat \"$1\"; echo; cut -d' ' -f1,6 /proc/$$/stat; } > " +
                                                  said.string() + ".new\nmv " + said.string() + ".new " +
                                                  said.string() + "\n"));
  std::filesystem::permissions(folder / "xdg-open", std::filesystem::perms::owner_all);
  const Variable path("PATH", (folder / "").string() + ":/usr/bin:/bin");
  const Variable temporary("TMPDIR", given.string());
  {
    const auto opened = OpenedLink::open("http://127.0.0.1:1/?token=2");
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_FALSE(std::filesystem::is_empty(given));
    while (!std::filesystem::exists(said)) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_TRUE(std::filesystem::is_empty(given));
  std::istringstream lines(read_file(said).value_or(""));
  std::string page;
  int process = 0, session = -1;
  std::getline(lines, page);
  lines >> process >> session;
  EXPECT_NE(page.find("url=http://127.0.0.1:1/?token=2"), std::string::npos) << page;
  EXPECT_EQ(session, process);
}

TEST(Serve, WhatCannotBeServedIsRefused) {
  const TestFolder folder;
  EXPECT_EQ(begun_and_ended({.port = 0}, folder / "missing").error().code, Errc::kNotFound);
  EXPECT_EQ(begun_and_ended({.port = 65536}, folder / "").error().code, Errc::kBadInput);
  EXPECT_EQ(begun_and_ended({.port = 0, .listen = "here"}, folder / "").error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
