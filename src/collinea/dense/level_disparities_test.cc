// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/level_disparities.h"

#include <gtest/gtest.h>

#include <cmath>

#include "collinea/dense/internal/test_pair.h"

namespace collinea {
namespace {

using test::DisparityErrors;
using test::TestPair;

Result<LevelDisparities> matched(const TestPair& pair, int grid_px, const Run& run = {}) {
  LevelOptions options;
  options.grid_px = grid_px;
  options.levels = 3;
  options.last_threshold = 200;
  options.min_entropy = 3;
  return match_rectified_by_levels(pair.image_of(true), pair.image_of(false), {0, 40}, options, run);
}

TEST(LevelDisparities, FindAPlaneAndAStep) {
  for (const double square : {0.0, 24.0}) {
    const TestPair pair{.at_left = 10, .slope = square > 0 ? 0 : 0.05, .square = square, .noise = 2};
    const auto found = matched(pair, 1);
    ASSERT_TRUE(found) << found.error().message;
    const DisparityErrors e = errors_of(pair, found->map, 12);
    // Measured: 97 % of the plane and 79 % beside the step, none and 31 gross, 0.045 and 0.033 px.
    EXPECT_GT(e.measured, (square > 0 ? 0.75 : 0.95) * e.possible) << square;
    EXPECT_LT(e.bad, (square > 0 ? 0.005 : 0.0005) * e.measured) << square;
    EXPECT_LT(e.rms, 0.06) << square;
  }
}

TEST(LevelDisparities, PointsAreThoseOfTheMap) {
  const TestPair pair{.at_left = 10, .slope = 0.05, .noise = 2};
  const auto found = matched(pair, 4);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(found->surface.levels.size(), 4u);
  std::size_t in_map = 0;
  for (const float d : found->map.disparity.data) in_map += !std::isnan(d);
  EXPECT_EQ(in_map, found->surface.points.size());
  for (const LevelPoint& point : found->surface.points)
    EXPECT_EQ(found->map.disparity.at(int(point.left_px.x()), int(point.left_px.y())), float(point.disparity_px));
}

TEST(LevelDisparities, StayInTheRange) {
  const TestPair pair{.at_left = 10, .slope = 0.1};  // 10 to 30
  LevelOptions options;
  options.grid_px = 3;
  options.min_entropy = 3;
  const auto found = match_rectified_by_levels(pair.image_of(true), pair.image_of(false), {0, 20}, options, {});
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_GT(found->surface.points.size(), 100u);
  for (const LevelPoint& point : found->surface.points) EXPECT_LE(point.disparity_px, 20.5);
}

TEST(LevelDisparities, TheNumberOfThreadsDoesNotMatter) {
  const TestPair pair{.at_left = 10, .slope = 0.05, .noise = 2};
  collinea::Run many;
  many.threads = 4;
  const auto alone = matched(pair, 4), shared = matched(pair, 4, many);
  ASSERT_TRUE(alone && shared);
  ASSERT_EQ(alone->surface.points.size(), shared->surface.points.size());
  for (std::size_t i = 0; i < alone->surface.points.size(); ++i)
    EXPECT_EQ(alone->surface.points[i].disparity_px, shared->surface.points[i].disparity_px);
}

TEST(LevelDisparities, NothingThatGuidesIsAnError) {
  const auto code = [&](const GreyImage& left, const GreyImage& right) {
    const auto found = match_rectified_by_levels(left, right, {0, 9}, {}, {});
    return found ? Errc::kNotFound : found.error().code;
  };
  EXPECT_EQ(code(GreyImage(80, 60, 1, 90), GreyImage(80, 60, 1, 90)), Errc::kIllPosed);
  EXPECT_EQ(code(GreyImage(80, 1, 1, 90), GreyImage(80, 1, 1, 90)), Errc::kIllPosed);
  EXPECT_EQ(code(GreyImage(1, 1, 1, 90), GreyImage(1, 1, 1, 90)), Errc::kIllPosed);
  EXPECT_EQ(code({}, {}), Errc::kBadInput);
  EXPECT_EQ(code(GreyImage(80, 60, 1, 90), GreyImage(80, 61, 1, 90)), Errc::kBadInput);
}

TEST(FillByTriangles, IsThePlaneThroughTheCorners) {
  const auto plane = [](double x, double y) { return 3 + 0.25 * x - 0.125 * y; };
  std::vector<LevelPoint> points;
  for (const auto& [x, y] : {std::pair{2.5, 2.5}, {27.5, 2.5}, {2.5, 17.5}, {27.5, 17.5}})
    points.push_back({{x, y}, plane(x, y), 0, 1, 0.1});
  FloatImage disparity(30, 20, 1, std::nanf(""));
  disparity.at(10, 10) = 99;  // stays
  fill_by_triangles(points, disparity, {});
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const float value = disparity.at(x, y);
      if (x == 10 && y == 10)
        EXPECT_EQ(value, 99);
      else if (x < 2 || y < 2 || x > 27 || y > 17)
        EXPECT_TRUE(std::isnan(value)) << x << ' ' << y;
      else if (x > 2 && y > 2 && x < 27 && y < 17)  // the rest lies on the outermost sides
        EXPECT_NEAR(value, plane(x + 0.5, y + 0.5), 1e-5) << x << ' ' << y;
    }
  FloatImage none(3, 3, 1, std::nanf(""));
  fill_by_triangles({}, none, {});
  EXPECT_TRUE(std::isnan(none.at(1, 1)));
}

}  // namespace
}  // namespace collinea
