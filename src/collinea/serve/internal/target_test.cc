// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/internal/target.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

using Parts = std::vector<std::string>;

TEST(Target, PathAndQueryAreUnescaped) {
  const auto target = parsed_target("/api/files/a%20b%2Fc/%C3%A4?token=x%3Dy&empty&token=z#part");
  ASSERT_TRUE(target);
  EXPECT_EQ(target->path, (Parts{"api", "files", "a b/c", "\xC3\xA4"}));
  EXPECT_EQ(target->query.at("token"), "x=y");
  EXPECT_EQ(target->query.at("empty"), "");
}

TEST(Target, TheRootHasNoParts) {
  EXPECT_EQ(parsed_target("/")->path, Parts{});
  EXPECT_EQ(parsed_target("/?a=b")->path, Parts{});
  EXPECT_EQ(parsed_target("/?a=b")->query.at("a"), "b");
  EXPECT_EQ(parsed_target("/a/")->path, (Parts{"a", ""}));
}

TEST(Target, WhatCannotBeRead) {
  for (const char* wrong :
       {"", "a", "http://host/", "*", "/%", "/%4", "/%zz", "/%00", "/%0a", "/\t", "/a?b=%", "/a?%f"})
    EXPECT_FALSE(parsed_target(wrong)) << wrong;
}

}  // namespace
}  // namespace collinea
