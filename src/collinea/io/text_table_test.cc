// SPDX-License-Identifier: Apache-2.0
#include "collinea/io/text_table.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collinea/io/photo_frame.h"

namespace collinea {
namespace {

TEST(TextTable, ColumnsHaveNamesUnitsAndValues) {
  const auto table =
      parse_text_table("# measured in June\npoint  x[mm] y [um]  sigma\n\n  A  1.5  -20 -  # good\n B 2 30 0.1\n");
  ASSERT_TRUE(table) << table.error().message;
  EXPECT_EQ(table->remarks, (std::vector<std::string>{"measured in June"}));
  EXPECT_EQ(table->columns, (std::vector<TableColumn>{{"point", ""}, {"x", "mm"}, {"y", "um"}, {"sigma", ""}}));
  EXPECT_EQ(table->words("point").value(), (std::vector<std::string>{"A", "B"}));
  EXPECT_EQ(table->numbers("x", "mm").value(), (std::vector<double>{1.5, 2}));
  EXPECT_NEAR(table->numbers("y", "mm").value()[0], -0.02, 1e-15);
  EXPECT_EQ(table->numbers_or("sigma", "mm", 7).value(), (std::vector<double>{7, 0.1}));
  EXPECT_EQ(table->numbers_or("weight", "1", 2).value(), (std::vector<double>{2, 2}));
}

TEST(TextTable, CommasAndSemicolonsPartColumnsWithBlanksInWords) {
  for (const char separator : {',', ';'}) {
    std::string text = "point,X[m],height\nnorth gate,1,2\nwell,,3\n";
    std::replace(text.begin(), text.end(), ',', separator);
    const auto table = parse_text_table(text);
    ASSERT_TRUE(table);
    EXPECT_EQ(table->rows[0][0], "north gate");
    EXPECT_EQ(table->numbers_or("X", "m", -1).value()[1], -1);
  }
}

TEST(TextTable, ReadsWhatItWrites) {
  TextTable table;
  table.remarks = {"a remark"};
  table.columns = {{"point", ""}, {"X", "m"}};
  table.rows = {{"gate 1", "12.5"}, {"b", ""}};
  const auto again = parse_text_table(text_of(table));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->remarks, table.remarks);
  EXPECT_EQ(again->columns, table.columns);
  EXPECT_EQ(again->rows, (std::vector<std::vector<std::string>>{{"gate_1", "12.5"}, {"b", "-"}}));
}

TEST(TextTable, SaysWhatIsWrongAndWhere) {
  const auto message = [](std::string_view text) {
    const auto table = parse_text_table(text);
    return table ? std::string() : table.error().message;
  };
  EXPECT_NE(message("").find("empty"), std::string::npos);
  EXPECT_NE(message("a b\n1\n").find("line 2 has 1 values below 2"), std::string::npos);
  EXPECT_NE(message("a a\n").find("two columns a"), std::string::npos);
  EXPECT_NE(message("a[furlong]\n").find("furlong"), std::string::npos);
  const auto table = parse_text_table("x_left[mm] y[deg]\n1 -\noops 2\n").value();
  EXPECT_NE(table.numbers("x_lefft", "mm").error().message.find("x_left"), std::string::npos);
  EXPECT_NE(table.numbers("x_left", "mm").error().message.find("row 2"), std::string::npos);
  EXPECT_NE(table.numbers("x_left", "px").error().message.find("in mm; wanted are px"), std::string::npos);
  EXPECT_NE(table.numbers("y", "deg").error().message.find("row 1 of the table gives no y"), std::string::npos);
}

TEST(TextTable, UnitsTurnIntoOthersOfTheirKindOnly) {
  EXPECT_DOUBLE_EQ(unit_factor("gon", "deg").value(), 0.9);
  EXPECT_DOUBLE_EQ(unit_factor("deg", "rad").value(), std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(unit_factor("um", "mm").value(), 1e-3);
  EXPECT_FALSE(unit_factor("mm", "px"));
  EXPECT_FALSE(unit_factor("mm", "ell"));
}

TEST(PhotoFrame, MillimetresLookUpAndPixelsDown) {
  PhotoOptions options{.principal_distance = 150, .principal_point = "1,2"};
  const PhotoFrame photo = photo_frame(options, "um").value();
  EXPECT_EQ(photo.pixel({10, 20}), Eigen::Vector2d(10, -20));
  EXPECT_EQ(photo.in_table(photo.pixel({10, 20})), Eigen::Vector2d(10, 20));
  // Above the principal point: y of the camera, which points down, is negative.
  EXPECT_LT((normalized(photo.camera, photo.pixel({1, 17})) - Eigen::Vector2d(0, -0.1)).norm(), 1e-15);
  const PhotoFrame image = photo_frame(options, "px").value();
  EXPECT_LT((normalized(image.camera, image.pixel({1, 17})) - Eigen::Vector2d(0, 0.1)).norm(), 1e-15);
}

TEST(PhotoFrame, WantsWhatItNeeds) {
  EXPECT_FALSE(photo_frame({}, "mm"));
  EXPECT_FALSE(photo_frame({.principal_distance = 150, .principal_point = "1"}, "mm"));
  EXPECT_FALSE(photo_frame({.principal_distance = 150}, "deg"));
}

}  // namespace
}  // namespace collinea
