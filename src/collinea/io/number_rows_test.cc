// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/number_rows.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TEST(NumberRows, TakesCommasAndWhiteSpaceTitlesAndRemarks) {
  const auto rows =
      parse_number_rows("\xEF\xBB\xBFname, x, y\n# remark\nA 1, 2, 3\n\nB\t4 5e-1 # here\r\n", true, 2, 3);
  ASSERT_TRUE(rows) << rows.error().message;
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[0].name, "A 1");
  EXPECT_EQ((*rows)[0].numbers, (std::vector<double>{2, 3}));
  EXPECT_EQ((*rows)[1].name, "B");
  EXPECT_EQ((*rows)[1].numbers, (std::vector<double>{4, 0.5}));
}

TEST(NumberRows, WithoutNamesRowsAreCounted) {
  const auto rows = parse_number_rows("easting northing\n1 2\n3 4\n", false, 2, 2);
  ASSERT_TRUE(rows);
  ASSERT_EQ(rows->size(), 2u);
  EXPECT_EQ((*rows)[1].name, "2");
  EXPECT_EQ((*rows)[1].numbers, (std::vector<double>{3, 4}));
  EXPECT_TRUE(parse_number_rows("", false, 2, 2)->empty());
}

TEST(NumberRows, ErrorsNameTheLine) {
  for (const char* wrong : {"A 1 2\nB 3\n", "A 1 2\nB 3 4 5 6\n", "A 1 2\nB 3 x\n", "A 1 2\nB 3 nan\n",
                            "A 1 2\nB inf 3\n", "A 1 2\nB\n", "A 1 2\nB,,3\n"}) {
    const auto rows = parse_number_rows(wrong, true, 2, 3);
    ASSERT_FALSE(rows) << wrong;
    EXPECT_EQ(rows.error().message, "line 2: 2 to 3 numbers behind a name are wanted");
  }
}

TEST(NumberRows, OneTitleAndNoRowsThatAreNone) {
  for (const char* wrong : {"A;1;2\nB;3;4\n", "name x y\nmm mm mm\nA 1 2\n"}) {
    const auto rows = parse_number_rows(wrong, true, 2, 3);
    ASSERT_FALSE(rows) << wrong;
    EXPECT_EQ(rows.error().message, "line 2: 2 to 3 numbers behind a name are wanted");
  }
}

TEST(Numbers, BetweenCommas) {
  EXPECT_EQ(parse_numbers("1, -2,3e1").value(), (std::vector<double>{1, -2, 30}));
  for (const char* wrong : {"", "1,", "1,x", "1 2", "nan", "1,inf"}) EXPECT_FALSE(parse_numbers(wrong)) << wrong;
}

}  // namespace
}  // namespace collinea
