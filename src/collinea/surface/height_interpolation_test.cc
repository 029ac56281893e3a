// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/height_interpolation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "collinea/math/random.h"

namespace collinea {
namespace {

std::vector<HeightPoint> points_of(int count, std::uint64_t seed, const std::function<double(double, double)>& height,
                                   double sigma_m = 0) {
  Random random(seed);
  std::vector<HeightPoint> points;
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(1000, 1100), y = random.uniform(2000, 2080);
    points.push_back({{x, y, height(x, y) + sigma_m * random.normal()}, sigma_m});
  }
  return points;
}

double plane(double x, double y) { return 3 + 0.2 * (x - 1000) - 0.1 * (y - 2000); }

// A random surface with a known covariance, at the points and at one position more (the last).
std::vector<double> random_heights(const std::vector<Eigen::Vector2d>& at, const HeightCovariance& covariance,
                                   Random& random) {
  const auto n = Eigen::Index(at.size());
  Eigen::MatrixXd all(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      all(i, j) = covariance.at((at[std::size_t(i)] - at[std::size_t(j)]).norm()) + (i == j ? 1e-9 : 0);
  Eigen::VectorXd normal(n);
  for (Eigen::Index i = 0; i < n; ++i) normal[i] = random.normal();
  const Eigen::VectorXd heights = all.llt().matrixL() * normal;
  return {heights.data(), heights.data() + n};
}

TEST(HeightInterpolation, EveryMethodGivesAPlaneBack) {
  const auto points = points_of(400, 1, plane);
  std::vector<std::unique_ptr<HeightInterpolation>> methods;
  methods.push_back(triangulated(points).value());
  methods.push_back(local_planes(points).value());
  methods.push_back(bicubic_splines(points, 10).value());
  methods.push_back(collocation(points, fit_covariance(points).value()).value());
  for (const auto& method : methods)
    for (const Eigen::Vector2d at : {Eigen::Vector2d(1050, 2040), Eigen::Vector2d(1020.3, 2071.9)})
      EXPECT_NEAR(method->at(at).height_m, plane(at.x(), at.y()), 1e-6);
}

TEST(HeightInterpolation, TrianglesGoThroughTheirPointsAndEndAtTheHull) {
  const std::vector<HeightPoint> points = {{{0, 0, 1}, 0.1}, {{4, 0, 5}, 0.1}, {{0, 4, 9}, 0.1}, {{40, 40, 0}, 0.1}};
  const auto triangles = triangulated(points, 10).value();
  EXPECT_NEAR(triangles->at({1, 1}).height_m, 1 + 1 + 2, 1e-6);
  EXPECT_NEAR(triangles->at({1, 1}).sigma_m, 0.1 * std::sqrt(0.25 + 0.0625 + 0.0625), 1e-6);
  EXPECT_TRUE(std::isnan(triangles->at({-1, 1}).height_m));
  EXPECT_TRUE(std::isnan(triangles->at({20, 20}).height_m));  // a side of more than 10 m
}

// Errors of the interpolated height of a plane from noisy points, in standard deviations: 600 surveys.
TEST(HeightInterpolation, SigmasOfPlanesSplinesAndTrianglesAreThoseOfTheirErrors) {
  const struct {
    const char* name;
    std::function<std::unique_ptr<HeightInterpolation>(const std::vector<HeightPoint>&)> make;
  } methods[] = {
      {"triangles", [](const auto& points) { return triangulated(points).value(); }},
      {"planes", [](const auto& points) { return local_planes(points, 20).value(); }},
      {"splines", [](const auto& points) { return bicubic_splines(points, 25).value(); }},
  };
  for (const auto& method : methods) {
    double squares = 0;
    int count = 0;
    for (std::uint64_t seed = 1; seed <= 600; ++seed) {
      const auto surface = method.make(points_of(120, seed, plane, 0.05));
      const InterpolatedHeight there = surface->at({1050, 2040});
      ASSERT_TRUE(std::isfinite(there.sigma_m)) << method.name;
      squares += std::pow((there.height_m - plane(1050, 2040)) / there.sigma_m, 2);
      ++count;
    }
    // Of planes the scatter is that of 17 points: t squared has a mean of 17 / 15.
    EXPECT_NEAR(squares / count, method.name == std::string("planes") ? 17.0 / 15 : 1, 0.15) << method.name;
  }
}

TEST(HeightInterpolation, CollocationKnowsItsErrors) {
  for (const Word<CovarianceModel>& model : kCovarianceModelWords) {
    const HeightCovariance truth{model.value, 4, model.value == CovarianceModel::kSpherical ? 40.0 : 20.0, 0.01};
    double squares = 0;
    int within = 0;
    constexpr int kSurfaces = 400;
    for (int k = 0; k < kSurfaces; ++k) {
      Random random(std::uint64_t(1000 + k));
      std::vector<Eigen::Vector2d> at;
      for (int i = 0; i < 60; ++i) at.emplace_back(random.uniform(0, 100), random.uniform(0, 100));
      at.emplace_back(random.uniform(20, 80), random.uniform(20, 80));
      const auto heights = random_heights(at, truth, random);
      std::vector<HeightPoint> points;
      for (std::size_t i = 0; i + 1 < at.size(); ++i)
        points.push_back({{at[i].x(), at[i].y(), heights[i] + 0.1 * random.normal()}, 0});
      const auto surface = collocation(points, {.covariance = truth}).value();
      const InterpolatedHeight there = surface->at(at.back());
      const double ratio = (there.height_m - heights.back()) / there.sigma_m;
      squares += ratio * ratio;
      within += std::abs(ratio) < 1.96;
    }
    EXPECT_NEAR(squares / kSurfaces, 1, 0.15) << model.word;
    EXPECT_NEAR(double(within) / kSurfaces, 0.95, 0.03) << model.word;
  }
}

TEST(HeightInterpolation, FindsTheCovarianceOfASurface) {
  const HeightCovariance truth{CovarianceModel::kExponential, 4, 6, 0.25};
  double signal = 0, noise = 0, errors = 0;
  constexpr int kSurfaces = 6;
  for (int k = 0; k < kSurfaces; ++k) {
    Random random(std::uint64_t(50 + k));
    std::vector<Eigen::Vector2d> at;
    for (int i = 0; i < 400; ++i) at.emplace_back(random.uniform(0, 100), random.uniform(0, 100));
    const auto heights = random_heights(at, truth, random);
    std::vector<HeightPoint> points;
    for (std::size_t i = 0; i < at.size(); ++i)
      points.push_back({{at[i].x(), at[i].y(), 100 + 0.1 * at[i].x() + heights[i] + 0.5 * random.normal()}, 0});
    const FittedCovariance fitted = fit_covariance(points, CovarianceModel::kExponential).value();
    signal += fitted.covariance.signal_m2 / kSurfaces;
    noise += fitted.covariance.noise_m2 / kSurfaces;
    errors += std::abs(std::log(fitted.covariance.range_m / truth.range_m)) / kSurfaces;
  }
  EXPECT_NEAR(signal, 4, 0.5);
  EXPECT_NEAR(noise, 0.25, 0.15);  // neighbours are 5 m apart, where the signal has lost more than half
  EXPECT_LT(errors, 0.4);
}

// A smooth surface with exact sigmas: nothing is left for noise of its own, and the fitted covariance knows the errors.
// Bounds: mean squares of 200 positions, which are correlated; 40 independent ones have a standard deviation of 0.22.
TEST(HeightInterpolation, ASmoothSurfaceHasNoNoiseOfItsOwn) {
  const auto hills = [](double x, double y) {
    return 100 + 4 * std::sin((x - 1000) / 17) + 3 * std::cos((y - 2000) / 13 + (x - 1000) / 40);
  };
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto points = points_of(400, seed, hills, 0.05);
    const FittedCovariance fitted = fit_covariance(points).value();
    EXPECT_LT(std::sqrt(fitted.covariance.noise_m2), 0.02) << seed;
    const auto surface = collocation(points, fitted).value();
    Random random(seed, 5);
    double squares = 0;
    for (int k = 0; k < 200; ++k) {
      const double x = random.uniform(1010, 1090), y = random.uniform(2010, 2090);
      const InterpolatedHeight there = surface->at({x, y});
      squares += std::pow((there.height_m - hills(x, y)) / there.sigma_m, 2) / 200;
    }
    EXPECT_NEAR(squares, 1, 0.66) << seed;
  }
}

// A fitted covariance serves as well as the true one: 40 surfaces of 200 points with known sigmas.
TEST(HeightInterpolation, AFittedCovarianceKnowsTheErrors) {
  double squares = 0;
  constexpr int kSurfaces = 40, kAt = 4;
  for (int k = 0; k < kSurfaces; ++k) {
    Random random(std::uint64_t(2000 + k));
    std::vector<Eigen::Vector2d> at;
    for (int i = 0; i < 200; ++i) at.emplace_back(random.uniform(0, 100), random.uniform(0, 100));
    for (int i = 0; i < kAt; ++i) at.emplace_back(25 + 50 * (i % 2), 25 + 50 * (i / 2));
    const auto heights = random_heights(at, {CovarianceModel::kGaussian, 4, 15, 0}, random);
    std::vector<HeightPoint> points;
    for (std::size_t i = 0; i < 200; ++i)
      points.push_back({{at[i].x(), at[i].y(), heights[i] + 0.1 * random.normal()}, 0.1});
    const auto surface = collocation(points, fit_covariance(points, CovarianceModel::kGaussian).value()).value();
    for (std::size_t i = 200; i < at.size(); ++i) {
      const InterpolatedHeight there = surface->at(at[i]);
      squares += std::pow((there.height_m - heights[i]) / there.sigma_m, 2) / (kSurfaces * kAt);
    }
  }
  EXPECT_NEAR(squares, 1, 4 * std::sqrt(2.0 / (kSurfaces * kAt)));
}

TEST(HeightInterpolation, RefusesWhatHasNoAnswer) {
  std::vector<HeightPoint> line;
  for (int i = 0; i < 50; ++i) line.push_back({{double(i), 2.0 * i, 1}, 0.1});
  EXPECT_FALSE(triangulated(line));
  EXPECT_FALSE(fit_covariance(line));
  EXPECT_TRUE(std::isnan(local_planes(line).value()->at({3, 5}).height_m));
  EXPECT_FALSE(triangulated({}));
  EXPECT_FALSE(local_planes(std::vector<HeightPoint>(3)));
  EXPECT_FALSE(fit_covariance(std::vector<HeightPoint>(29)));
  EXPECT_FALSE(bicubic_splines(std::vector<HeightPoint>(15), 1));
  EXPECT_FALSE(bicubic_splines(points_of(100, 1, plane), 0.01));
}

}  // namespace
}  // namespace collinea
