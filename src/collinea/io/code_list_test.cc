// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/code_list.h"

#include <gtest/gtest.h>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"

namespace collinea {
namespace {

TEST(CodeList, TheOneOfTheProgramIsReadByItsOwnReader) {
  const auto codes = parse_code_list(default_code_list());
  ASSERT_TRUE(codes) << codes.error().message;
  EXPECT_GT(codes->size(), 10u);
  EXPECT_EQ(codes->front().code, "B");
  EXPECT_EQ(codes->front().layer, "building");
  EXPECT_EQ(codes->front().kind, VectorKind::kPolygon);
  EXPECT_EQ(text_of(codes->front().colour), "#c0392b");
  EXPECT_EQ(codes->front().meaning, "outline of a building at the ground");
}

TEST(CodeList, AFolderHasItsOwnOrThatOfTheProgram) {
  const TestFolder folder;
  EXPECT_GT(code_list_of(folder / "")->size(), 10u);
  ASSERT_TRUE(write_file(folder / "codes.txt", "code layer kind\nA a line\n"));
  EXPECT_EQ(code_list_of(folder / "")->size(), 1u);
  ASSERT_TRUE(write_file(folder / "codes.txt", "code layer kind\nA a blob\n"));
  EXPECT_NE(code_list_of(folder / "").error().message.find("codes.txt: row 1: \"blob\" is no kind"), std::string::npos);
}

TEST(CodeList, WhatIsWrongIsNamedWithItsRow) {
  EXPECT_NE(parse_code_list("code layer kind\nA a line\nA b line\n").error().message.find("row 2: code A stands twice"),
            std::string::npos);
  EXPECT_NE(parse_code_list("code; layer; kind; colour\nA; a; line; red\n").error().message.find("such as c00000"),
            std::string::npos);
  EXPECT_FALSE(parse_code_list("code; layer\nA; a\n"));
  EXPECT_FALSE(parse_code_list("code; layer; kind\n-; a; line\n"));
}

}  // namespace
}  // namespace collinea
