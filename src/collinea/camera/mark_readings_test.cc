// SPDX-License-Identifier: Apache-2.0
#include "collinea/camera/mark_readings.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

TEST(MarkReadings, TheSecondReaderOfMarkThreeIsNamed) {
  // Image 27 of film_pairs, marks 3 and 4: the second reading of 3 is that of image 28.
  const std::vector<MarkReading> readings = {{"3", {1345, 1471}},   {"4", {19163, 19283}}, {"3", {1358, 1473}},
                                             {"4", {19163, 19283}}, {"3", {1345, 1471}},   {"4", {19167, 19282}},
                                             {"3", {1346, 1472}},   {"4", {19163, 19283}}};
  const ReadMarks read = mean_of_readings(readings, 0.5);
  ASSERT_EQ(read.marks.size(), 2u);
  EXPECT_EQ(read.marks[0].gross, std::vector<int>{2});
  // Of the 16 deviations six are 0 and six 0.5 px: median 0.5, spread 1.4826 sqrt(4/3) 0.5 = 0.856 px, limit 4.28 px.
  // The third reading of mark 4 is off by 4 px and stays.
  EXPECT_NEAR(read.limit, 5 * 1.4826 * std::sqrt(4.0 / 3) * 0.5, 1e-9);
  EXPECT_TRUE(read.marks[1].gross.empty());
  EXPECT_NEAR(read.marks[0].position.x(), 1345 + 1.0 / 3, 1e-9);
  EXPECT_NEAR(read.marks[0].scatter.y(), std::sqrt(1.0 / 3), 1e-9);
  EXPECT_EQ(read.marks[0].good, 3);
  EXPECT_EQ(read.degrees, 10);
}

TEST(MarkReadings, TwoThatDisagreeAreBothKept) {
  const std::vector<MarkReading> readings = {{"1", {100, 100}}, {"1", {114, 100}}, {"2", {7, 8}}};
  const ReadMarks read = mean_of_readings(readings, 0.5);
  EXPECT_TRUE(read.marks[0].is_contested);
  EXPECT_EQ(read.marks[0].good, 2);
  EXPECT_FALSE(read.marks[1].is_contested);
  EXPECT_EQ(read.degrees, 0);
  EXPECT_TRUE(mean_of_readings({}, 0.5).marks.empty());
}

TEST(MarkReadings, TheirScatterIsThatOfTheNoise) {
  Random random(4);
  std::vector<MarkReading> readings;
  for (int mark = 0; mark < 200; ++mark)
    for (int i = 0; i < 4; ++i)
      readings.push_back({std::to_string(mark), {10.0 * mark + 2 * random.normal(), 2 * random.normal()}, 2});
  const ReadMarks read = mean_of_readings(readings, 0.1);
  EXPECT_NEAR(read.sigma, 2, 0.2);
  EXPECT_NEAR(read.limit, 10, 2);
  EXPECT_NEAR(read.marks[0].sigma, 1, 1e-9);
}

}  // namespace
}  // namespace collinea
