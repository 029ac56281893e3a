// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/interest_covariance.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "collinea/feature/test_shapes.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

GreyImage rounded(const FloatImage& image) {
  GreyImage out(image.width, image.height);
  for (std::size_t i = 0; i < out.data.size(); ++i)
    out.data[i] = std::uint8_t(std::clamp(std::lround(image.data[i]), 0L, 255L));
  return out;
}

// A corner of 75 degrees, of blurred edges, or a disc.
FloatImage scene(bool is_disc, const Vector2d& at) {
  if (is_disc) return render_shape(41, 41, disc(at, 2.5, 1));
  return render_shape(41, 41, [&](const Vector2d& p) {
    const Vector2d q = p - at;
    return blurred_step(q.x(), 1) * blurred_step(0.966 * q.y() - 0.259 * q.x(), 1);
  });
}

InterestOptions options_of(InterestOperator method) {
  InterestOptions options;
  options.method = method;
  options.sub_pixel = SubPixel::kParaboloid;
  options.sigma_px = method == InterestOperator::kLog || method == InterestOperator::kDog ? 1.8 : 1.5;
  options.max_points = 1;
  options.evenness = 0;
  return options;
}

constexpr InterestOperator kWithSigmas[] = {
    InterestOperator::kHarris,    InterestOperator::kNoble, InterestOperator::kKovesi, InterestOperator::kShiTomasi,
    InterestOperator::kFoerstner, InterestOperator::kLog,   InterestOperator::kDog};

// The derivatives: a grey value more in one pixel moves the top by g_p. All pixels, one by one, give the covariance of
// unit noise: sum of g_p g_p'. One grey value of 120 leaves second order of a hundredth.
TEST(InterestCovariance, IsTheSumOfTheSquaresOfWhatEachPixelDoes) {
  for (const InterestOperator method : kWithSigmas) {
    const bool is_disc = method == InterestOperator::kLog || method == InterestOperator::kDog;
    const InterestOptions options = options_of(method);
    GreyImage image = rounded(scene(is_disc, {20.7, 20.2}));
    const InterestPoints found = find_interest_points(image, options);
    ASSERT_EQ(found.points.size(), 1u) << word_of(method);
    const FloatImage map = interest_map(image, options);
    const auto highest = std::max_element(map.data.begin(), map.data.end()) - map.data.begin();
    const int column = int(highest) % map.width, row = int(highest) / map.width;
    const auto covariance = paraboloid_covariance(image, column, row, options, 1);
    ASSERT_TRUE(covariance) << word_of(method);
    Matrix2d numeric = Matrix2d::Zero();
    for (int y = 5; y < 36; ++y)
      for (int x = 5; x < 36; ++x) {
        Vector2d sides[2];
        for (const int side : {0, 1}) {
          image.at(x, y) = std::uint8_t(image.at(x, y) + (side == 0 ? -1 : 2));
          const auto moved = find_interest_points(image, options).points;
          ASSERT_EQ(moved.size(), 1u);
          sides[side] = moved[0].position_px;
        }
        image.at(x, y) = std::uint8_t(image.at(x, y) - 1);
        const Vector2d by = (sides[1] - sides[0]) / 2;
        numeric += by * by.transpose();
      }
    EXPECT_LT((numeric - *covariance).norm(), 0.02 * covariance->norm()) << word_of(method);
  }
}

// Where the top lies within 0.3 px of the middle of its pixel: between two pixels noise decides whose paraboloid is
// taken, and the two differ by some hundredths of a pixel.
std::optional<FloatImage> away_from_borders(bool is_disc, const InterestOptions& options) {
  for (const Vector2d& at : {Vector2d(20.7, 20.2), Vector2d(20.5, 20.5), Vector2d(20.3, 20.7), Vector2d(20.9, 20.9)}) {
    const FloatImage image = scene(is_disc, at);
    const auto found = find_interest_points(rounded(image), options);
    if (found.points.size() != 1) continue;
    const Vector2d from_middle =
        found.points[0].position_px.array() - found.points[0].position_px.array().floor() - 0.5;
    if (from_middle.cwiseAbs().maxCoeff() < 0.3) return image;
  }
  return std::nullopt;
}

// e' C^-1 e about the position without noise is chi-squared with two degrees of freedom: the mean of n is 2 with a
// standard deviation of sqrt(4 / n). Four of those, and 5 % for what noise of 2 does to gradients of 20 and more in
// second order. Rounding is noise of 1/12.
TEST(InterestCovariance, IsThatOfTheErrors) {
  constexpr int kTrials = 400;
  constexpr double kNoise_grey = 2;
  for (const InterestOperator method : kWithSigmas) {
    const bool is_disc = method == InterestOperator::kLog || method == InterestOperator::kDog;
    InterestOptions options = options_of(method);
    options.noise_grey = std::sqrt(kNoise_grey * kNoise_grey + 1.0 / 12);
    const auto image = away_from_borders(is_disc, options);
    ASSERT_TRUE(image) << word_of(method);
    const auto truth = find_interest_points(rounded(*image), options);
    double sum = 0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= kTrials; ++seed) {
      const GreyImage noisy = rounded(with_noise(*image, kNoise_grey, seed));
      InterestPoints found = find_interest_points(noisy, options);
      add_paraboloid_covariances(noisy, options, found);
      ASSERT_EQ(found.points.size(), 1u);
      if (!found.points[0].covariance_px2) continue;
      const Vector2d error = found.points[0].position_px - truth.points[0].position_px;
      sum += error.dot(found.points[0].covariance_px2->inverse() * error);
      ++count;
    }
    ASSERT_GT(count, 0.95 * kTrials) << word_of(method);
    EXPECT_NEAR(sum / count, 2, 4 * std::sqrt(4.0 / count) + 0.1) << word_of(method);
  }
}

TEST(InterestCovariance, ThereIsNoneWhereNothingTellsIt) {
  const GreyImage image = rounded(scene(false, {20.7, 20.2})), flat(41, 41, 1, 90);
  EXPECT_FALSE(paraboloid_covariance(image, 20, 20, options_of(InterestOperator::kMoravec), 1));
  EXPECT_FALSE(paraboloid_covariance(image, 20, 20, options_of(InterestOperator::kSift), 1));
  EXPECT_FALSE(paraboloid_covariance(image, 3, 20, options_of(InterestOperator::kHarris), 1));
  EXPECT_FALSE(paraboloid_covariance(image, 3, 20, options_of(InterestOperator::kDog), 1));
  for (const InterestOperator method : kWithSigmas)
    EXPECT_FALSE(paraboloid_covariance(flat, 20, 20, options_of(method), 1)) << word_of(method);
  EXPECT_FALSE(paraboloid_covariance(image, 33, 20, options_of(InterestOperator::kHarris), 1));  // an edge: no top
}

}  // namespace
}  // namespace collinea
