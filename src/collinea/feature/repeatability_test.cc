// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/repeatability.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;

std::vector<InterestPoint> points_at(const std::vector<Vector2d>& positions) {
  std::vector<InterestPoint> points;
  for (const Vector2d& p : positions) points.push_back({.position_px = p});
  return points;
}

GreyImage waves(int width, int height) {
  GreyImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      image.at(x, y) =
          static_cast<std::uint8_t>(std::lround(128 + 60 * std::sin(0.31 * (x + 0.5)) * std::cos(0.27 * (y + 0.5))));
  return image;
}

// Karfis W5: two of three points of the second run were found in the first, 66.67 %.
TEST(Repeatability, TheRateOfKarfisW5) {
  const auto first = points_at({{10, 10}, {30, 12}, {50, 50}, {70, 20}}),
             second = points_at({{10.4, 10}, {29.5, 12}, {80, 80}});
  const Repeatability r = repeatability(first, second, Matrix3d::Identity(), {100, 100, 100, 100, 0}, 1);
  EXPECT_EQ(r.repeated, 2u);
  EXPECT_NEAR(r.rate_of_second(), 0.6667, 1e-4);
  EXPECT_NEAR(r.rate(), 0.6667, 1e-4);
  EXPECT_NEAR(r.rms_px, std::sqrt((0.16 + 0.25) / 2), 1e-12);
}

TEST(Repeatability, APointIsFoundOnceAndOnlyWhereBothImagesLook) {
  const auto first = points_at({{10, 10}, {2, 50}}), second = points_at({{10.5, 10}, {9.8, 10}, {2, 50}});
  const Repeatability r = repeatability(first, second, Matrix3d::Identity(), {100, 100, 100, 100, 5}, 1);
  EXPECT_EQ(r.first, 1u);
  EXPECT_EQ(r.second, 2u);
  EXPECT_EQ(r.repeated, 1u);
  EXPECT_NEAR(r.rms_px, 0.2, 1e-12);
  EXPECT_EQ(repeatability({}, {}, Matrix3d::Identity(), {}, 1).rate(), 0);
}

TEST(Repeatability, ChangedImagesShowWhatTheirMappingSays) {
  const GreyImage image = waves(120, 90);
  const struct {
    ImageChange change;
    double amount;
  } cases[] = {{ImageChange::kRotation, 0}, {ImageChange::kRotation, 30}, {ImageChange::kRotation, 180},
               {ImageChange::kScale, 1.37}, {ImageChange::kScale, 0.8},   {ImageChange::kNoise, 0}};
  for (const auto& [change, amount] : cases) {
    const ChangedImage there = changed(image, change, amount, 1);
    double worst = 0;
    for (int y = 0; y < there.image.height; ++y)
      for (int x = 0; x < there.image.width; ++x) {
        const Vector2d p = (there.from_original.inverse() * Vector2d(x + 0.5, y + 0.5).homogeneous()).hnormalized();
        if (p.x() < 3 || p.y() < 3 || p.x() > 117 || p.y() > 87) continue;
        const double expected = 128 + 60 * std::sin(0.31 * p.x()) * std::cos(0.27 * p.y());
        worst = std::max(worst, std::abs(there.image.at(x, y) - expected));
      }
    EXPECT_LT(worst, amount < 1 && amount > 0 ? 4.0 : 1.6) << amount;  // a smaller image is blurred
  }
}

TEST(Repeatability, NoiseIsAsLargeAsAskedAndTheSameForASeed) {
  const GreyImage image(200, 200, 1, 128);
  const GreyImage noisy = changed(image, ImageChange::kNoise, 6, 4).image;
  double squares = 0;
  for (const auto value : noisy.data) squares += (value - 128.0) * (value - 128.0);
  EXPECT_NEAR(std::sqrt(squares / 40000), 6, 0.1);
  EXPECT_EQ(noisy.data, changed(image, ImageChange::kNoise, 6, 4).image.data);
  EXPECT_NE(noisy.data, changed(image, ImageChange::kNoise, 6, 5).image.data);
}

// Karfis W7: turned by 30 degrees, Moravec's operator answers at the stairs of slanted edges; Foerstner's does not.
TEST(Repeatability, MoravecSeesCornersOnSlantedEdges) {
  GreyImage image(120, 120, 1, 40);
  for (int y = 40; y < 80; ++y)
    for (int x = 40; x < 80; ++x) image.at(x, y) = 220;
  const GreyImage turned = changed(image, ImageChange::kRotation, 30, 1).image;
  const auto count = [](const GreyImage& of, InterestOperator method) {
    return find_interest_points(of, {.method = method, .relative_threshold = 0.1, .radius_px = 2}).points.size();
  };
  EXPECT_EQ(count(image, InterestOperator::kMoravec), 4u);
  EXPECT_GT(count(turned, InterestOperator::kMoravec), 8u);
  EXPECT_EQ(count(image, InterestOperator::kFoerstner), 4u);
  EXPECT_EQ(count(turned, InterestOperator::kFoerstner), 4u);
}

}  // namespace
}  // namespace collinea
