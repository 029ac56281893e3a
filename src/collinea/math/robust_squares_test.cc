// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/robust_squares.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "collinea/math/random.h"

namespace collinea {
namespace {

double normal_square(Random& random, int coordinates) {
  double s = 0;
  for (int i = 0; i < coordinates; ++i) s += std::pow(random.normal(), 2);
  return s;
}

TEST(RobustSquares, WithoutALossAreTheSquares) {
  RobustSquares squares({Loss::kNone, 1});
  squares.add(4, 2);
  squares.add(9, 3);
  EXPECT_DOUBLE_EQ(squares.squares(), 13);
  EXPECT_EQ(squares.information(0.3), 1);
  for (const auto kind : {Loss::kHuber, Loss::kCauchy}) {
    EXPECT_EQ(RobustSquares({kind, 2}).squares(), 0);
    EXPECT_EQ(RobustSquares({kind, 2}).information(0.3), 1);
    RobustSquares exact({kind, 2});
    for (int i = 0; i < 10; ++i) exact.add(0, 2);
    EXPECT_EQ(exact.squares(), 0);
    EXPECT_EQ(exact.information(0.3), 1);
    RobustSquares lost({kind, 2});  // beyond any hope, but a number
    for (int i = 0; i < 10; ++i) lost.add(1e12, 2);
    EXPECT_TRUE(std::isfinite(lost.squares()) && std::isfinite(lost.information(0.3)));
  }
}

// The variance of normal residuals is found whatever the loss and the sigma. A variance from n coordinates is known by
// sqrt(2 / n), by a factor of about 1.2 less under the losses (their efficiency): four of that, and 1e-3 of quadrature.
TEST(RobustSquares, FindTheVarianceOfNormalResiduals) {
  Random random(3);
  for (const auto kind : {Loss::kHuber, Loss::kCauchy})
    for (const double sigma : {0.5, 1.0, 2.0}) {
      RobustSquares squares({kind, 2});
      double coordinates = 0;
      for (int i = 0; i < 60000; ++i) {
        const int c = 1 + i % 3;
        squares.add(sigma * sigma * normal_square(random, c), c);
        coordinates += c;
      }
      EXPECT_NEAR(squares.squares() / coordinates / (sigma * sigma), 1, 4 * 1.5 * std::sqrt(2 / coordinates) + 1e-3)
          << kind << " " << sigma;
    }
}

// The mean of vectors by a robust loss, many times: its real variance against that of the normal equations,
// variance / (information sum w). Normal errors and errors with the long tails of Student's distribution of three
// degrees of freedom; 4000 means have their variance known by sqrt(2 / 8000) = 1.6 %: four of that, and 1 % because
// the theory is that of many observations.
TEST(RobustSquares, InformationMakesTheNormalEquationsTrue) {
  for (const auto kind : {Loss::kHuber, Loss::kCauchy})
    for (const bool long_tails : {false, true}) {
      Random random(5);
      double real = 0, predicted = 0;
      constexpr int kMeans = 4000, kVectors = 100;
      for (int m = 0; m < kMeans; ++m) {
        std::vector<std::pair<double, double>> errors;
        for (int i = 0; i < kVectors; ++i) {
          const double x = random.normal(), y = random.normal();
          const double stretch = long_tails ? std::sqrt(3 / normal_square(random, 3)) : 1;
          errors.emplace_back(stretch * x, stretch * y);
        }
        const Loss loss{kind, 2};
        double mean_x = 0, mean_y = 0, weights = 0;
        for (int round = 0; round < 30; ++round) {
          double sum_x = 0, sum_y = 0;
          weights = 0;
          for (const auto& [x, y] : errors) {
            const double w = loss.weight(std::pow(x - mean_x, 2) + std::pow(y - mean_y, 2));
            sum_x += w * x, sum_y += w * y, weights += w;
          }
          mean_x = sum_x / weights, mean_y = sum_y / weights;
        }
        RobustSquares squares(loss);
        for (const auto& [x, y] : errors) squares.add(std::pow(x - mean_x, 2) + std::pow(y - mean_y, 2), 2);
        real += mean_x * mean_x + mean_y * mean_y;
        predicted += 2 * squares.squares() / (2 * kVectors - 2) / (squares.information(1.0 / kVectors) * weights);
      }
      EXPECT_NEAR(real / predicted, 1, 4 * 0.016 + 0.01) << kind << long_tails;
    }
}

}  // namespace
}  // namespace collinea
