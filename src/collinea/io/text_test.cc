// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/text.h"

#include <gtest/gtest.h>

#include "collinea/io/internal/separators.h"

namespace collinea {
namespace {

// Of one, two, three and four bytes in UTF-8; the last is a pair in UTF-16.
TEST(Utf16, CharactersOfEveryLengthComeThrough) {
  using namespace std::string_literals;
  const std::string expected = "a\xc3\xb6\xe2\x82\xac\xf0\x9d\x84\x9e\n";
  const auto little = converted_to_utf8("\xff\xfe\x61\x00\xf6\x00\xac\x20\x34\xd8\x1e\xdd\x0a\x00"s);
  ASSERT_TRUE(little && *little);
  EXPECT_EQ(**little, expected);
  const auto big = converted_to_utf8("\xfe\xff\x00\x61\x00\xf6\x20\xac\xd8\x34\xdd\x1e\x00\x0a"s);
  ASSERT_TRUE(big && *big);
  EXPECT_EQ(**big, expected);
}

TEST(Utf16, OtherTextIsLeftAsItIs) {
  for (const char* text : {"", "a",
                           "\xef\xbb\xbf"
                           "a",
                           "\xc3\xb6", "\xf6 of Latin 1", "\xff", "\xfe"}) {
    const auto converted = converted_to_utf8(text);
    ASSERT_TRUE(converted) << text;
    EXPECT_FALSE(*converted) << text;
  }
}

TEST(Utf16, WhatIsNoTextIsRefusedByItsLine) {
  using namespace std::string_literals;
  const auto binary = converted_to_utf8("one\ntwo\nthree\0four"s);
  ASSERT_FALSE(binary);
  EXPECT_EQ(binary.error().message, "line 3: a byte of 0, which no text has: not a text file");
  EXPECT_FALSE(converted_to_utf8("\xff\xfe\x00\xdc\x61\x00"s));  // the second half of a pair alone
}

TEST(Separators, HintsNameWhatIsThereAndWhatIsExpected) {
  EXPECT_EQ(number_hint("-12,50"), " (a decimal comma? Write -12.50)");
  for (const char* none : {"12.5", "1,2,3", ",5", "12,", "twelve", "1.234,5"}) EXPECT_EQ(number_hint(none), "") << none;
  EXPECT_EQ(separator_hint("a;b", ','), " (semicolons in the line; commas are expected)");
  EXPECT_EQ(separator_hint("a\tb", ','), " (tabs in the line; commas are expected)");
  EXPECT_EQ(separator_hint("a b", ';'), " (blanks in the line; semicolons are expected)");
  EXPECT_EQ(separator_hint("a, b", ' '), " (commas in the line; blanks are expected)");
  EXPECT_EQ(separator_hint("1,5 2", ' '), " (a decimal comma? Write 1.5)");
  EXPECT_EQ(separator_hint("a,b;c", ','), "");
  EXPECT_EQ(separator_hint("a\tb", ' '), "");
}

}  // namespace
}  // namespace collinea
