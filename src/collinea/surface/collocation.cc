// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/geometry/plane_squares.h"
#include "collinea/surface/height_interpolation.h"
#include "collinea/surface/internal/covariance_likelihood.h"

namespace collinea {
namespace {

constexpr std::size_t kFewestPoints = 30;
constexpr std::size_t kMostOfVariogram = 2000;  // points whose pairs are looked at
constexpr int kClasses = 15;
constexpr double kPartOfExtent = 1.0 / 3;  // largest distance of a pair
constexpr int kRanges = 60;                // that are tried for each model
constexpr double kSmallest = 1e-12;

double correlation(CovarianceModel model, double h) {
  switch (model) {
    case CovarianceModel::kExponential:
      return std::exp(-h);
    case CovarianceModel::kGaussian:
      return std::exp(-h * h);
    case CovarianceModel::kSpherical:
      return h >= 1 ? 0 : 1 - 1.5 * h + 0.5 * h * h * h;
  }
  return 0;
}

double height_less_trend(const HeightPoint& point, const FittedCovariance& fitted) {
  const Eigen::Vector2d from = point.position.head<2>() - fitted.middle;
  return point.position.z() - fitted.trend.dot(Eigen::Vector3d(1, from.x(), from.y()));
}

// The plane by least squares; false when the points lie on a line.
bool fit_trend(std::span<const HeightPoint> points, FittedCovariance& fitted) {
  for (const HeightPoint& point : points) fitted.middle += point.position.head<2>() / double(points.size());
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double extent_m = 0;
  for (const HeightPoint& point : points)
    extent_m = std::max(extent_m, (point.position.head<2>() - fitted.middle).norm());
  if (!(extent_m > 0)) return false;
  for (const HeightPoint& point : points) {
    const Eigen::Vector2d from = (point.position.head<2>() - fitted.middle) / extent_m;
    const Eigen::Vector3d row(1, from.x(), from.y());
    normal += row * row.transpose();
    right += row * point.position.z();
  }
  const Eigen::LDLT<Eigen::Matrix3d> factors(normal);
  if (!(factors.vectorD().minCoeff() > 1e-9 * double(points.size()))) return false;
  fitted.trend = factors.solve(right);
  fitted.trend.tail<2>() /= extent_m;
  return true;
}

std::vector<VariogramClass> variogram(std::span<const HeightPoint> points, const FittedCovariance& fitted) {
  const std::size_t stride = (points.size() + kMostOfVariogram - 1) / kMostOfVariogram;
  std::vector<std::pair<Eigen::Vector2d, double>> some;
  Eigen::Vector2d low = points[0].position.head<2>(), high = low;
  for (std::size_t i = 0; i < points.size(); i += stride)
    some.emplace_back(points[i].position.head<2>(), height_less_trend(points[i], fitted));
  for (const auto& [position, height] : some) {
    low = low.cwiseMin(position);
    high = high.cwiseMax(position);
  }
  const double farthest_m = kPartOfExtent * (high - low).norm();
  std::vector<VariogramClass> classes(kClasses);
  for (std::size_t i = 0; i < some.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double distance_m = (some[i].first - some[j].first).norm();
      if (!(distance_m < farthest_m)) continue;
      VariogramClass& of = classes[std::size_t(kClasses * distance_m / farthest_m)];
      of.distance_m += distance_m;
      of.half_square_m2 += std::pow(some[i].second - some[j].second, 2) / 2;
      ++of.pairs;
    }
  std::erase_if(classes, [](const VariogramClass& each) { return each.pairs == 0; });
  for (VariogramClass& each : classes) {
    each.distance_m /= double(each.pairs);
    each.half_square_m2 /= double(each.pairs);
  }
  return classes;
}

// Noise and signal of a model with that range, both at least zero, and the weighted sum of squares.
std::pair<HeightCovariance, double> fitted_to(const std::vector<VariogramClass>& classes, CovarianceModel model,
                                              double range_m) {
  const auto squares_of = [&](double noise, double signal) {
    double sum = 0;
    for (const VariogramClass& each : classes) {
      const double rest = each.half_square_m2 - noise - signal * (1 - correlation(model, each.distance_m / range_m));
      sum += double(each.pairs) * std::pow(rest / std::max(each.half_square_m2, kSmallest), 2);
    }
    return sum;
  };
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right = Eigen::Vector2d::Zero();
  for (const VariogramClass& each : classes) {
    const double weight = double(each.pairs) / std::pow(std::max(each.half_square_m2, kSmallest), 2);
    const Eigen::Vector2d row(1, 1 - correlation(model, each.distance_m / range_m));
    normal += weight * row * row.transpose();
    right += weight * row * each.half_square_m2;
  }
  Eigen::Vector2d both = normal.ldlt().solve(right);
  if (!both.allFinite() || both.y() < 0) both = {right.x() / normal(0, 0), 0};
  if (both.x() < 0) both = {0, std::max(right.y() / normal(1, 1), 0.0)};
  return {{model, both.y(), range_m, both.x()}, squares_of(both.x(), both.y())};
}

// The range with the least squares.
std::pair<HeightCovariance, double> best_of(const std::vector<VariogramClass>& classes, CovarianceModel model,
                                            double nearest_m, double farthest_m) {
  std::pair<HeightCovariance, double> best{{}, std::numeric_limits<double>::infinity()};
  for (int i = 0; i < kRanges; ++i) {
    const double range_m = nearest_m * std::pow(2 * farthest_m / nearest_m, double(i) / (kRanges - 1));
    const auto found = fitted_to(classes, model, range_m);
    if (found.second < best.second) best = found;
  }
  return best;
}

class Collocation : public HeightInterpolation {
 public:
  Collocation(std::span<const HeightPoint> points, const FittedCovariance& fitted, int nearest)
      : points_(points.begin(), points.end()),
        squares_(in_plan(points)),
        fitted_(fitted),
        nearest_(std::size_t(nearest)) {
    for (const HeightPoint& point : points_) rest_.push_back(height_less_trend(point, fitted));
  }

  [[nodiscard]] InterpolatedHeight at(const Eigen::Vector2d& on_map) const override {
    const std::vector<std::size_t> nearest = squares_.nearest(on_map, nearest_);
    const auto n = Eigen::Index(nearest.size());
    const HeightCovariance& covariance = fitted_.covariance;
    Eigen::MatrixXd all(n, n);
    Eigen::MatrixXd right(n, 3);  // covariances with the position, ones, heights
    for (Eigen::Index i = 0; i < n; ++i) {
      const HeightPoint& point = points_[nearest[std::size_t(i)]];
      const Eigen::Vector2d here = point.position.head<2>();
      for (Eigen::Index j = 0; j < i; ++j)
        all(i, j) = covariance.at((points_[nearest[std::size_t(j)]].position.head<2>() - here).norm());
      // A millionth for points on one position with exact heights.
      all(i, i) = covariance.signal_m2 * (1 + 1e-6) + covariance.noise_m2 + point.sigma_m * point.sigma_m + kSmallest;
      right.row(i) << covariance.at((here - on_map).norm()), 1, rest_[nearest[std::size_t(i)]];
    }
    const Eigen::LLT<Eigen::MatrixXd> factors(all);  // of the lower half
    if (factors.info() != Eigen::Success) return {};
    const Eigen::MatrixXd solved = factors.solve(right);
    const double ones = right.col(1).dot(solved.col(1));
    const double mean = right.col(1).dot(solved.col(2)) / ones;
    const double known = right.col(0).dot(solved.col(1));
    const double height = mean + right.col(0).dot(solved.col(2) - mean * solved.col(1));
    const double variance = covariance.signal_m2 - right.col(0).dot(solved.col(0)) + (1 - known) * (1 - known) / ones;
    const Eigen::Vector2d from = on_map - fitted_.middle;
    return {height + fitted_.trend.dot(Eigen::Vector3d(1, from.x(), from.y())), std::sqrt(std::max(variance, 0.0))};
  }

 private:
  std::vector<HeightPoint> points_;
  PlaneSquares squares_;
  FittedCovariance fitted_;
  std::size_t nearest_;
  std::vector<double> rest_;  // heights less the trend
};

}  // namespace

double HeightCovariance::at(double distance_m) const { return signal_m2 * correlation(model, distance_m / range_m); }

Result<FittedCovariance> fit_covariance(std::span<const HeightPoint> points, std::optional<CovarianceModel> model) {
  if (points.size() < kFewestPoints)
    return fail(Errc::kIllPosed,
                fmt::format("a covariance function needs {} points; there are {}", kFewestPoints, points.size()));
  FittedCovariance fitted;
  if (!fit_trend(points, fitted)) return fail(Errc::kIllPosed, "the points lie on one line");
  fitted.variogram = variogram(points, fitted);
  const double farthest_m = fitted.variogram.back().distance_m, nearest_m = fitted.variogram.front().distance_m / 5;
  double mean_square_m2 = 0;
  std::vector<double> heights;
  for (const HeightPoint& point : points) {
    mean_square_m2 += point.sigma_m * point.sigma_m / double(points.size());
    heights.push_back(height_less_trend(point, fitted));
  }
  double most = std::numeric_limits<double>::infinity(), least = most;
  for (const Word<CovarianceModel>& named : kCovarianceModelWords) {
    if (model && *model != named.value) continue;
    auto [start, squares] = best_of(fitted.variogram, named.value, nearest_m, farthest_m);
    start.noise_m2 = std::max(start.noise_m2 - mean_square_m2, 0.0);
    const LikelyCovariance likely = most_likely(points, heights, start, nearest_m / 5, 4 * farthest_m);
    // Where there is no likelihood (all on the trend), the variogram decides.
    const bool is_better = std::isfinite(likely.minus_log_likelihood) ? likely.minus_log_likelihood < most
                                                                      : !std::isfinite(most) && squares < least;
    if (!is_better) continue;
    most = likely.minus_log_likelihood;
    least = squares;
    fitted.covariance = likely.covariance;
  }
  return fitted;
}

Result<std::unique_ptr<HeightInterpolation>> collocation(std::span<const HeightPoint> points,
                                                         const FittedCovariance& fitted, int nearest) {
  if (points.empty() || nearest < 1) return fail(Errc::kIllPosed, "collocation needs points");
  return std::make_unique<Collocation>(points, fitted, nearest);
}

}  // namespace collinea
