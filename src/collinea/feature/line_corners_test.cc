// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/line_corners.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "collinea/feature/edges.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

// With edge points at both ends.
FoundLine line(double theta_rad, double r_px, const Vector2d& from, const Vector2d& to,
               std::vector<EdgePoint>& points) {
  FoundLine out;
  for (const Vector2d& p : {from, to}) {
    out.points.push_back(points.size());
    points.push_back({.at = p, .normal = Vector2d(std::cos(theta_rad), std::sin(theta_rad))});
  }
  out.line.theta_rad = theta_rad;
  out.line.r_px = r_px;
  out.line.from = from;
  out.line.to = to;
  return out;
}

TEST(LineCorners, AreWhereTheLinesMeetWithinReach) {
  std::vector<EdgePoint> points;
  const std::vector<FoundLine> lines = {
      line(0, 30, {30, 10}, {30, 50}, points),                     // x = 30
      line(std::numbers::pi / 2, 60, {35, 60}, {90, 60}, points),  // y = 60
      line(0, 70, {70, 20}, {70, 100}, points)};  // x = 70: crosses the second where neither has an edge point
  const auto corners = line_corners(lines, points, {.least_angle_deg = 20, .reach_px = 11});
  ASSERT_EQ(corners.size(), 1u);
  EXPECT_EQ(corners[0].first, 0u);
  EXPECT_EQ(corners[0].second, 1u);
  EXPECT_LT((corners[0].at - Vector2d(30, 60)).norm(), 1e-12);
  EXPECT_NEAR(corners[0].gap_px, 10, 1e-12);
  EXPECT_NEAR(corners[0].angle_rad, std::numbers::pi / 2, 1e-9);
  EXPECT_TRUE(line_corners(lines, points, {.least_angle_deg = 20, .reach_px = 9}).empty());
  EXPECT_TRUE(line_corners({}, {}, {}).empty());
}

TEST(LineCorners, CovarianceIsThatOfTheDerivatives) {
  std::vector<EdgePoint> points;
  std::vector<FoundLine> lines = {line(0.4, 50, {}, {}, points), line(1.7, 80, {}, {}, points)};
  lines[0].line.covariance << 4e-6, 1e-4, 1e-4, 9e-3;
  lines[1].line.covariance << 1e-6, -2e-4, -2e-4, 6e-2;
  const LineCornerOptions anywhere{.least_angle_deg = 1, .reach_px = 1e5};
  const LineCorner corner = line_corners(lines, points, anywhere).at(0);
  Matrix2d expected = Matrix2d::Zero();
  for (std::size_t k = 0; k < 2; ++k) {
    Matrix2d jacobian;
    for (int p = 0; p < 2; ++p) {
      constexpr double kStep = 1e-6;
      auto there = lines, back = lines;
      (p == 0 ? there[k].line.theta_rad : there[k].line.r_px) += kStep;
      (p == 0 ? back[k].line.theta_rad : back[k].line.r_px) -= kStep;
      jacobian.col(p) =
          (line_corners(there, points, anywhere).at(0).at - line_corners(back, points, anywhere).at(0).at) /
          (2 * kStep);
    }
    expected += jacobian * lines[k].line.covariance * jacobian.transpose();
  }
  EXPECT_LT((corner.covariance - expected).norm(), 1e-7 * expected.norm());
}

// A turned bright square with soft edges and noise: all four corners, and errors as large as their covariances say
// (chi-squared with 2 degrees of freedom, mean 2, standard deviation 2 / sqrt(n)).
TEST(LineCorners, ErrorsAreAsStated) {
  constexpr double kTurn = 0.3, kHalf = 40, kNoise = 2;
  const Vector2d middle(64.3, 63.6);
  Random random(5);
  double sum = 0;
  int n = 0, within = 0;
  Vector2d mean = Vector2d::Zero();
  for (int trial = 0; trial < 100; ++trial) {
    FloatImage image(128, 128);
    for (int y = 0; y < 128; ++y)
      for (int x = 0; x < 128; ++x) {
        const Vector2d p = Vector2d(x + 0.5, y + 0.5) - middle;
        const double u = std::cos(kTurn) * p.x() + std::sin(kTurn) * p.y();
        const double v = -std::sin(kTurn) * p.x() + std::cos(kTurn) * p.y();
        const auto inside = [&](double d) { return 0.5 * (std::erf((d + kHalf) / 1.4) - std::erf((d - kHalf) / 1.4)); };
        image.at(x, y) = static_cast<float>(60 + 120 * inside(u) * inside(v) + kNoise * random.normal());
      }
    const EdgeMap map = detect_edges(image, {.noise_grey = kNoise});
    const auto corners = line_corners(hough_lines(edge_points_of(map), {}), map.points, {});
    ASSERT_EQ(corners.size(), 4u) << trial;
    for (const LineCorner& c : corners) {
      Vector2d error = Vector2d(1e9, 1e9);
      for (const double su : {-kHalf, kHalf})
        for (const double sv : {-kHalf, kHalf}) {
          const Vector2d truth = middle + Vector2d(std::cos(kTurn) * su - std::sin(kTurn) * sv,
                                                   std::sin(kTurn) * su + std::cos(kTurn) * sv);
          if ((c.at - truth).norm() < error.norm()) error = c.at - truth;
        }
      ASSERT_LT(error.norm(), 0.3);
      const double q = error.dot(c.covariance.ldlt().solve(error));
      sum += q;
      within += q < 5.991;
      ++n;
      mean += error;
    }
  }
  RecordProperty("chi_squared_per_freedom", std::to_string(sum / (2 * n)));
  EXPECT_NEAR(sum / n, 2, 4 * 2 / std::sqrt(double(n)));
  EXPECT_NEAR(double(within) / n, 0.95, 0.035);
  EXPECT_LT((mean / n).norm(), 0.01);
}

}  // namespace
}  // namespace collinea
