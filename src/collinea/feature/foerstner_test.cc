// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/foerstner.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <random>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kSize = 41;
const Vector2d kTruth(20.31, 20.84);

constexpr auto kFollowing = FoerstnerWindow::kFollowing;
constexpr auto kFixed = FoerstnerWindow::kFixed;

// What a feature looks like at a point given from its middle: -1 to 1.
using Look = std::function<double(const Vector2d&)>;

double soft(double x) { return std::erf(x / 1.3); }  // an edge blurred by 0.9 px

Vector2d turned(const Vector2d& d, double angle) {
  return {std::cos(angle) * d.x() + std::sin(angle) * d.y(), -std::sin(angle) * d.x() + std::cos(angle) * d.y()};
}

double chequerboard(const Vector2d& d) {
  const Vector2d t = turned(d, 0.4);
  return soft(t.x()) * soft(t.y());
}
double corner(const Vector2d& d) {
  const Vector2d t = turned(d, 0.4);
  return (1 + soft(t.x())) * (1 + soft(t.y())) / 2 - 1;
}
double disc(const Vector2d& d) { return soft(4 - d.norm()); }

std::vector<double> rendered(const Look& look) {
  std::vector<double> image;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) image.push_back(128 + 80 * look(Vector2d(x + 0.5, y + 0.5) - kTruth));
  return image;
}

GreyImage with_noise(const std::vector<double>& image, double noise, std::mt19937_64& random) {
  GreyImage out(kSize, kSize);
  std::normal_distribution<double> normal(0, 1);
  for (std::size_t i = 0; i < image.size(); ++i)
    out.data[i] = static_cast<std::uint8_t>(std::clamp(std::lround(image[i] + noise * normal(random)), 0L, 255L));
  return out;
}

struct Spreads {
  double chi2_per_freedom = 0, within_95 = 0;
  Vector2d bias = Vector2d::Zero(), sigma = Vector2d::Zero();
};

// Estimates over many images of different noise, beside the covariances stated. Reference: the truth, or their own
// mean.
Spreads simulated(const Look& look, FoerstnerModel model, FoerstnerWindow window, double noise, bool is_biased) {
  constexpr int kImages = 400;
  const std::vector<double> clean = rendered(look);
  std::mt19937_64 random(11);
  std::vector<FoerstnerPoint> found;
  for (int i = 0; i < kImages; ++i) {
    const double with_rounding = std::hypot(noise, std::sqrt(1.0 / 12));
    const Vector2d start = window == kFixed ? kTruth : Vector2d(20.5, 20.5);  // of its error a quarter stays
    const auto point = foerstner_point(with_noise(clean, noise, random), start, 2, model, window, with_rounding);
    EXPECT_TRUE(point.has_value());
    if (point) found.push_back(*point);
  }
  Spreads s;
  const auto n = static_cast<double>(found.size());
  for (const FoerstnerPoint& p : found) {
    s.bias += (p.position_px - kTruth) / n;
    s.sigma += p.covariance_px2.diagonal() / n;
  }
  s.sigma = s.sigma.cwiseSqrt();
  const Vector2d reference = is_biased ? Vector2d(kTruth + s.bias) : kTruth;
  for (const FoerstnerPoint& p : found) {
    const Vector2d error = p.position_px - reference;
    const double chi2 = error.dot(p.covariance_px2.inverse() * error);
    s.chi2_per_freedom += chi2 / (2 * n);
    s.within_95 += (chi2 < 5.991464547) / n;
  }
  return s;
}

// Chi-squared of 400 estimates with two degrees of freedom each: mean 1, standard deviation 0.05.
TEST(Foerstner, TheCovarianceOfAChequerboardIsTrue) {
  for (const auto& [window, noise] : {std::pair{kFollowing, 1.0}, {kFollowing, 4.0}, {kFixed, 1.0}, {kFixed, 4.0}}) {
    const Spreads s = simulated(chequerboard, FoerstnerModel::kCorner, window, noise, false);
    EXPECT_NEAR(s.chi2_per_freedom, 1, 0.1) << noise;
    EXPECT_NEAR(s.within_95, 0.95, 0.025) << noise;
    EXPECT_LT(s.bias.norm(), 0.004) << noise;
  }
}

TEST(Foerstner, TheCovarianceOfADiscIsTrue) {
  const Spreads s = simulated(disc, FoerstnerModel::kCircle, kFollowing, 3, false);
  EXPECT_NEAR(s.chi2_per_freedom, 1, 0.1);
  EXPECT_NEAR(s.within_95, 0.95, 0.025);
  EXPECT_LT(s.bias.norm(), 0.004);
}

// The blur of a corner draws the point to its inside by more than its noise: stated in the header.
TEST(Foerstner, TheCovarianceOfACornerIsThatOfItsScatter) {
  const Spreads s = simulated(corner, FoerstnerModel::kCorner, kFollowing, 3, true);
  EXPECT_NEAR(s.chi2_per_freedom, 1, 0.1);
  EXPECT_LT(s.bias.norm(), 0.35);
  EXPECT_GT(s.bias.norm(), 0.05);
}

// Covariance by the numeric derivative of the position by every pixel.
TEST(Foerstner, TheCovarianceIsThatOfNumericDerivatives) {
  for (const auto& [look, model, window] : {std::tuple{Look(corner), FoerstnerModel::kCorner, kFollowing},
                                            {Look(disc), FoerstnerModel::kCircle, kFollowing},
                                            {Look(corner), FoerstnerModel::kCorner, kFixed},
                                            {Look(disc), FoerstnerModel::kCircle, kFixed}}) {
    std::mt19937_64 random(3);
    const GreyImage image = with_noise(rendered(look), 5, random);
    const Vector2d start(20.5, 20.5);
    const auto middle = foerstner_point(image, start, 1.5, model, window, 1);
    ASSERT_TRUE(middle);
    Matrix2d sum = Matrix2d::Zero();
    for (int y = 6; y < 36; ++y)
      for (int x = 6; x < 36; ++x) {
        GreyImage more = image, less = image;
        more.at(x, y) = static_cast<std::uint8_t>(more.at(x, y) + 1);
        less.at(x, y) = static_cast<std::uint8_t>(less.at(x, y) - 1);
        const auto a = foerstner_point(more, start, 1.5, model, window, 1);
        const auto b = foerstner_point(less, start, 1.5, model, window, 1);
        ASSERT_TRUE(a && b);
        const Vector2d by_pixel = (a->position_px - b->position_px) / 2;
        sum += by_pixel * by_pixel.transpose();
      }
    EXPECT_LT((sum - middle->covariance_px2).norm(), 0.01 * sum.norm());
  }
}

TEST(Foerstner, RoundnessTellsCornersFromEdges) {
  std::mt19937_64 random(1);
  const auto board = foerstner_point(with_noise(rendered(chequerboard), 1, random), {20.5, 20.5}, 2,
                                     FoerstnerModel::kCorner, kFollowing, 1);
  ASSERT_TRUE(board);
  EXPECT_GT(board->roundness, 0.9);
  const Look edge = [](const Vector2d& d) { return soft(turned(d, 0.3).x()); };
  EXPECT_FALSE(
      foerstner_point(with_noise(rendered(edge), 0, random), {20.5, 20.5}, 2, FoerstnerModel::kCorner, kFollowing, 1));
}

TEST(Foerstner, WhatLeavesNoPointIsRefused) {
  const GreyImage flat(kSize, kSize, 1, 90);
  EXPECT_FALSE(foerstner_point(flat, {20, 20}, 2, FoerstnerModel::kCorner, kFollowing, 1));
  std::mt19937_64 random(1);
  const GreyImage image = with_noise(rendered(chequerboard), 1, random);
  for (const Vector2d& beside : {Vector2d(2, 20), Vector2d(20, 39), Vector2d(-50, 3), Vector2d(30, 8)})
    EXPECT_FALSE(foerstner_point(image, beside, 2, FoerstnerModel::kCorner, kFollowing, 1)) << beside.transpose();
}

TEST(Foerstner, NoiseIsFoundInRenderedImages) {
  std::mt19937_64 random(5);
  for (const double noise : {1.0, 3.0, 10.0}) {
    std::normal_distribution<double> normal(0, noise);
    GreyImage image(300, 200);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 300; ++x)
        image.at(x, y) = static_cast<std::uint8_t>(
            std::clamp(std::lround(128 + 40 * std::sin(0.05 * x) + 30 * (x > 150) + normal(random)), 0L, 255L));
    EXPECT_NEAR(noise_of(image), std::hypot(noise, 0.289), 0.04 * noise);
  }
  EXPECT_NEAR(noise_of(GreyImage(50, 50, 1, 3)), 0.289, 1e-3);
  EXPECT_NEAR(noise_of(GreyImage()), 0.289, 1e-3);
}

}  // namespace
}  // namespace collinea
