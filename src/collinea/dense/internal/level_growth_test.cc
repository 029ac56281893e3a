// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/level_growth.h"

#include <gtest/gtest.h>

#include "collinea/dense/internal/plane_pair.h"

namespace collinea {
namespace {

using testing::kHeight, testing::kWidth, testing::PlanePair;

constexpr int kStep_px = 6;
const PlanePair& pair() {
  static const PlanePair made({0.3, -0.2}, 2, 5);
  return made;
}

std::vector<Eigen::Vector2i> grid() {
  std::vector<Eigen::Vector2i> pixels;
  for (int y = kStep_px / 2; y < kHeight; y += kStep_px)
    for (int x = kStep_px / 2; x < kWidth; x += kStep_px) pixels.emplace_back(x, y);
  return pixels;
}

LevelPoint seed(const Eigen::Vector2i& pixel, double error_px) {
  return {
      pixel.cast<double>() + Eigen::Vector2d(0.5, 0.5), pair().disparity(pixel) + error_px, 0, 1, 0, pair().gradient};
}

GrowthOptions options() {
  GrowthOptions made;
  made.step_px = kStep_px;
  made.min_ncc = 0.8;
  made.rows = [](const Eigen::Vector2i&) { return 1; };
  return made;
}

// Whether a window there, a pixel round it and the cubic's neighbours lie in both images, a column kept.
bool is_inside(const Eigen::Vector2i& pixel) {
  constexpr int kMargin_px = 6 + 2;
  const double left = pixel.x() - kMargin_px / 0.7 - kMargin_px * 0.2 / 0.7,
               right = pixel.x() + kMargin_px / 0.7 + kMargin_px * 0.2 / 0.7,
               there = pixel.x() - pair().disparity(pixel);
  return left >= 1 && right < kWidth - 2 && there >= kMargin_px + 3 && there < kWidth - kMargin_px - 3 &&
         pixel.y() >= kMargin_px && pixel.y() < kHeight - kMargin_px;
}

// From one match all of a sloping plane is found, to some hundredths of a pixel: five of the stated standard
// deviations, which are a fifth too small (TheFitErrsAsItSays), are not reached by one in 800.
TEST(LevelGrowth, SpreadsOverAPlane) {
  const Eigen::Vector2i middle(147, 57);
  const auto points = grown(pair().left, pair().right, grid(), {seed(middle, 0.3)}, options(), collinea::Run{});
  std::size_t inside = 0, found = 0;
  for (const Eigen::Vector2i& pixel : grid()) inside += is_inside(pixel);
  for (const LevelPoint& point : points) {
    const Eigen::Vector2i pixel = point.left_px.cast<int>();
    found += is_inside(pixel);
    if (pixel == middle) continue;  // stays as it was given
    EXPECT_LT(std::abs(point.disparity_px - pair().disparity(pixel)), 5 * point.sigma_px) << pixel.transpose();
    EXPECT_LT(point.sigma_px, 0.05) << pixel.transpose();
  }
  EXPECT_GT(inside, 300U);
  EXPECT_EQ(found, inside);
}

TEST(LevelGrowth, AWrongSeedStaysAlone) {
  const auto points = grown(pair().left, pair().right, grid(), {seed({147, 57}, 9)}, options(), collinea::Run{});
  EXPECT_EQ(points.size(), 1U);
}

TEST(LevelGrowth, WithoutSeedsNothingGrows) {
  EXPECT_TRUE(grown(pair().left, pair().right, grid(), {}, options(), collinea::Run{}).empty());
}

TEST(LevelGrowth, ThreadsChangeNothing) {
  const auto with = [](int threads) {
    collinea::Run run;
    run.threads = threads;
    return grown(pair().left, pair().right, grid(), {seed({147, 57}, 0)}, options(), run);
  };
  const auto one = with(1), three = with(3);
  ASSERT_EQ(one.size(), three.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    EXPECT_EQ(one[i].left_px, three[i].left_px);
    EXPECT_EQ(one[i].disparity_px, three[i].disparity_px);
  }
}

}  // namespace
}  // namespace collinea
