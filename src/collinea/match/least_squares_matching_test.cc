// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/least_squares_matching.h"

#include <gtest/gtest.h>

#include <hwy/targets.h>
#include <Eigen/Dense>
#include <cmath>
#include <functional>
#include <numbers>

#include "collinea/math/random.h"
#include "collinea/math/test_targets.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kSize = 64;
const Vector2d kMiddle(32.2, 31.7);

// A surface painted with waves of 8 to 20 pixels.
class Texture {
 public:
  explicit Texture(std::uint64_t seed) {
    Random random(seed);
    for (Wave& wave : waves_) {
      const double length_px = random.uniform(8, 20), angle = random.uniform(0, 2 * std::numbers::pi);
      const double k = 2 * std::numbers::pi / length_px;
      wave = {k * std::cos(angle), k * std::sin(angle), random.uniform(0, 2 * std::numbers::pi)};
    }
  }
  double operator()(const Vector2d& at) const {
    double sum = 128;
    for (const Wave& wave : waves_) sum += 9 * std::sin(wave.x * at.x() + wave.y * at.y() + wave.phase);
    return sum;
  }

 private:
  struct Wave {
    double x = 0, y = 0, phase = 0;
  };
  std::array<Wave, 12> waves_;
};

// The image of a surface: position (0.5, 0.5) is the centre of its first pixel.
GreyImage image_of(const std::function<double(const Vector2d&)>& grey, double noise_grey = 0, std::uint64_t seed = 1) {
  Random random(seed);
  GreyImage image(kSize, kSize);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      image.at(x, y) = static_cast<std::uint8_t>(
          std::clamp(std::round(grey({x + 0.5, y + 0.5}) + noise_grey * random.normal()), 0.0, 255.0));
  return image;
}

// What is at position + warp * offset in the other image is at kMiddle + offset in the reference.
GreyImage other_image(const Texture& texture, const Placement& placement, double gain = 1, double offset = 0,
                      double noise_grey = 0, std::uint64_t seed = 2) {
  const Matrix2d back = placement.warp.inverse();
  return image_of(
      [&](const Vector2d& at) { return gain * texture(kMiddle + back * (at - placement.position_px)) + offset; },
      noise_grey, seed);
}

std::optional<ReferenceWindow> window_of(const GreyImage& image) {
  return ReferenceWindow::of(*cut_patch(image, 1, kMiddle), kMiddle);
}

std::optional<LeastSquaresMatch> found_in(const GreyImage& image, const ReferenceWindow& window, const Placement& start,
                                          double farthest_px = 2) {
  return window.find(*cut_patch(image, 1, start.position_px), start, farthest_px);
}

TEST(LeastSquaresMatching, FindsShiftsOfPartsOfAPixel) {
  const Texture texture(3);
  const auto window = window_of(image_of(texture));
  ASSERT_TRUE(window);
  for (int i = 0; i < 16; ++i) {
    const Placement truth{kMiddle + Vector2d(i % 4, i / 4) * 0.25, Matrix2d::Identity()};
    const auto found = found_in(other_image(texture, truth), *window, {kMiddle, Matrix2d::Identity()});
    ASSERT_TRUE(found);
    EXPECT_LT((found->placement.position_px - truth.position_px).norm(), 0.01);  // grey values are whole numbers
    EXPECT_GT(found->correlation, 0.99);
  }
}

TEST(LeastSquaresMatching, FindsTheAffineMapUnderOtherLight) {
  const Texture texture(5);
  const auto window = window_of(image_of(texture));
  ASSERT_TRUE(window);
  Placement truth{kMiddle + Vector2d(0.6, -0.45), {}};
  truth.warp << 0.93, -0.17, 0.11, 1.12;
  const auto found = found_in(other_image(texture, truth, 0.6, 40), *window, {kMiddle, Matrix2d::Identity()});
  ASSERT_TRUE(found);
  EXPECT_LT((found->placement.position_px - truth.position_px).norm(), 0.02);
  EXPECT_LT((found->placement.warp - truth.warp).norm(), 0.01);
}

TEST(LeastSquaresMatching, LevelsOfAPyramidHaveTheSamePositions) {
  const Texture texture(7);
  const auto window = ReferenceWindow::of(*cut_patch(image_of(texture), 2, 2 * kMiddle), 2 * kMiddle);  // pixels of two
  ASSERT_TRUE(window);
  const Placement truth{2 * kMiddle + Vector2d(0.9, -0.7), Matrix2d::Identity()};
  const GreyImage other = other_image(texture, {truth.position_px / 2, truth.warp});
  const auto found = window->find(*cut_patch(other, 2, truth.position_px), {2 * kMiddle, Matrix2d::Identity()}, 4);
  ASSERT_TRUE(found);
  EXPECT_LT((found->placement.position_px - truth.position_px).norm(), 0.02);
}

GreyImage noisy(const std::vector<double>& clean, double noise_grey, std::uint64_t seed) {
  Random random(seed);
  GreyImage image(kSize, kSize);
  for (std::size_t i = 0; i < clean.size(); ++i)
    image.data[i] =
        static_cast<std::uint8_t>(std::clamp(std::round(clean[i] + noise_grey * random.normal()), 0.0, 255.0));
  return image;
}

// e' C^-1 e is chi-squared with two degrees of freedom: mean 2, standard deviation 2, of the mean of n trials
// 2 / sqrt(n). Sigmas by white residuals gave 2.37 with the smaller noise; with the larger one that of the slopes
// counts, too.
TEST(LeastSquaresMatching, CovarianceMatchesTheRealErrors) {
  constexpr std::uint64_t kTextures = 25, kTrials = 20;
  for (const double noise_grey : {2.0, 5.0}) {
    double sum = 0;
    int count = 0;
    Random random(11);
    for (std::uint64_t t = 0; t < kTextures; ++t) {
      const Texture texture(100 + t);
      const Vector2d truth = kMiddle + Vector2d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      std::vector<double> clean, moved;
      for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
          const Vector2d at(x + 0.5, y + 0.5);
          clean.push_back(texture(at));
          moved.push_back(0.9 * texture(at - truth + kMiddle) + 5);
        }
      for (std::uint64_t trial = 0; trial < kTrials; ++trial) {
        const auto window = window_of(noisy(clean, noise_grey, 1000 * t + 2 * trial));
        ASSERT_TRUE(window);
        const GreyImage other = noisy(moved, noise_grey, 1000 * t + 2 * trial + 1);
        const auto found = found_in(other, *window, {kMiddle, Matrix2d::Identity()});
        if (!found) continue;
        const auto covariance = window->covariance(*cut_patch(other, 1, kMiddle), *found);
        ASSERT_TRUE(covariance);
        const Vector2d error = found->placement.position_px - truth;
        sum += error.dot(covariance->relative_px2().inverse() * error);
        ++count;
      }
    }
    ASSERT_GT(count, 0.95 * kTextures * kTrials);
    EXPECT_NEAR(sum / count, 2, 4 * 2 / std::sqrt(count)) << noise_grey;
  }
}

TEST(LeastSquaresMatching, ConstantImagesAndStraightEdgesFixNoPosition) {
  EXPECT_FALSE(window_of(image_of([](const Vector2d&) { return 90; })));
  const auto edge = [](const Vector2d& at) { return 128 + 90 * std::tanh((at - kMiddle).dot(Vector2d(0.8, 0.6)) / 3); };
  EXPECT_FALSE(window_of(image_of(edge)));
}

TEST(LeastSquaresMatching, RefusesAnotherTextureAndDistantPositions) {
  const Texture texture(3);
  const auto window = window_of(image_of(texture));
  ASSERT_TRUE(window);
  const Placement start{kMiddle, Matrix2d::Identity()};
  EXPECT_FALSE(found_in(image_of(Texture(4)), *window, start));
  EXPECT_FALSE(found_in(image_of([](const Vector2d&) { return 90; }), *window, start));
  const GreyImage moved = other_image(texture, {kMiddle + Vector2d(1.2, 0), Matrix2d::Identity()});
  EXPECT_TRUE(found_in(moved, *window, start, 1.5));
  EXPECT_FALSE(found_in(moved, *window, start, 1));
  EXPECT_FALSE(found_in(moved, *window, {Vector2d(5, 30), Matrix2d::Identity()}));  // not all of it is there
  EXPECT_FALSE(found_in(moved, *window, {kMiddle, Matrix2d::Zero()}));
  EXPECT_FALSE(cut_patch(GreyImage(40, 64), 1, kMiddle));
}

TEST(LeastSquaresMatching, EveryProcessorGivesTheSameBits) {
  const Texture texture(9);
  const GreyImage reference = image_of(texture, 3);
  const GreyImage other = other_image(texture, {kMiddle + Vector2d(0.3, 0.4), Matrix2d::Identity()}, 1, 0, 3);
  std::vector<Vector2d> positions;
  for (const std::int64_t target : testing::processor_targets()) {
    const testing::OnTarget chosen(target);
    const auto window = window_of(reference);
    ASSERT_TRUE(window);
    const auto found = found_in(other, *window, {kMiddle, Matrix2d::Identity()});
    ASSERT_TRUE(found);
    positions.push_back(found->placement.position_px);
    EXPECT_EQ(positions.back(), positions.front()) << hwy::TargetName(target);
  }
}

}  // namespace
}  // namespace collinea
