// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/serve.h"

#include <gtest/gtest.h>

#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

// What the log says of a server that ends as soon as it has begun.
Result<std::vector<std::string>> begun_and_ended(const ServeOptions& options, const std::filesystem::path& folder) {
  std::vector<std::string> lines;
  std::stop_source stop;
  stop.request_stop();
  COLLINEA_TRY(serve({folder}, options,
                     {.stop = stop.get_token(), .log = [&](std::string_view line) { lines.emplace_back(line); }}));
  return lines;
}

TEST(Serve, TheLinkLeadsToThisMachine) {
  const TestFolder folder;
  const auto lines = begun_and_ended({.port = 0}, folder / "");
  ASSERT_TRUE(lines) << lines.error().message;
  ASSERT_EQ(lines->size(), 1u);
  EXPECT_NE(lines->front().find("0 projects; open http://127.0.0.1:"), std::string::npos) << lines->front();
  EXPECT_NE(lines->front().find("/?token="), std::string::npos);
}

TEST(Serve, BeyondThisMachineIsWarnedOf) {
  const TestFolder folder;
  const auto open = begun_and_ended({.port = 0, .listen = "0.0.0.0"}, folder / "");
  ASSERT_TRUE(open) << open.error().message;
  EXPECT_TRUE(open->front().starts_with("warning:")) << open->front();
  const auto closed = begun_and_ended({.port = 0, .listen = "127.0.0.1"}, folder / "");
  ASSERT_TRUE(closed) << closed.error().message;
  EXPECT_FALSE(closed->front().starts_with("warning:")) << closed->front();
}

TEST(Serve, WhatCannotBeServedIsRefused) {
  const TestFolder folder;
  EXPECT_EQ(begun_and_ended({.port = 0}, folder / "missing").error().code, Errc::kNotFound);
  EXPECT_EQ(begun_and_ended({.port = 65536}, folder / "").error().code, Errc::kBadInput);
  EXPECT_EQ(begun_and_ended({.port = 0, .listen = "here"}, folder / "").error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
