// SPDX-License-Identifier: Apache-2.0
#include "collinea/epipolar/internal/two_view_criteria.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "collinea/epipolar/internal/homography.h"
#include "collinea/epipolar/internal/relative.h"

namespace collinea {
namespace {

constexpr double kLogFalseAlarms = -4.6;

// Logarithm of the binomial coefficient (std::lgamma writes a global variable, which threads may not).
double log_choose(std::size_t n, std::size_t k) {
  double sum = 0;
  for (std::size_t i = 1; i <= k; ++i) sum += std::log(static_cast<double>(n - k + i) / static_cast<double>(i));
  return sum;
}

constexpr double kStill_px = 1.5, kSlow_px = 6;
constexpr std::size_t kLeastMarks = 5, kStillForEachSlow = 4;
constexpr double kNearlyAll = 0.9;

double moved_px(std::span<const Keypoint> first, std::span<const Keypoint> second, const Match& match) {
  const Keypoint &a = first[match.first], &b = second[match.second];
  return std::hypot(double{b.x} - a.x, double{b.y} - a.y);
}

constexpr int kRotationCells = 18;
constexpr int kScaleCells = 18;  // of half an octave, the middle one around equal scales

int wrapped(int cell) { return (cell % kRotationCells + kRotationCells) % kRotationCells; }

std::pair<int, int> cell_of(const RotationAndScale& change) {
  const double turns = change.rotation_rad / (2 * std::numbers::pi);
  const int rotation = static_cast<int>((turns - std::floor(turns)) * kRotationCells);
  const double scale = std::clamp(std::round(2 * change.log2_scale) + kScaleCells / 2, 1.0, kScaleCells - 2.0);
  return {wrapped(rotation), static_cast<int>(scale)};
}

}  // namespace

PointPairs with_focal_factor(const PointPairs& pairs, double first, double second) {
  PointPairs result = pairs;
  result.focal_first_px *= first;
  result.focal_second_px *= second;
  for (auto* values : {&result.x1, &result.y1})
    for (double& value : *values) value /= first;
  for (auto* values : {&result.x2, &result.y2})
    for (double& value : *values) value /= second;
  return result;
}

std::vector<double> errors_of(const Eigen::Matrix3d& matrix, const PointPairs& pairs, bool is_homography) {
  std::vector<double> errors(static_cast<std::size_t>(pairs.size()));
  if (is_homography)
    squared_errors(matrix, pairs, 0, pairs.size(), errors.data());
  else
    squared_epipolar_errors(matrix, pairs, 0, pairs.size(), errors.data());
  return errors;
}

std::vector<int> below(const std::vector<double>& squared_px2, double threshold_px) {
  std::vector<int> items;
  for (std::size_t i = 0; i < squared_px2.size(); ++i)
    if (squared_px2[i] < threshold_px * threshold_px) items.push_back(static_cast<int>(i));
  return items;
}

double truncated_cost(const std::vector<double>& squared_px2, double threshold_px) {
  double sum = 0;
  for (const double e : squared_px2) sum += e < threshold_px * threshold_px ? e : threshold_px * threshold_px;
  return sum;
}

double gric(const std::vector<double>& squared_px2, std::span<const int> items, double sigma_px, int dimension,
            int parameters) {
  constexpr double kMeasured = 4;  // coordinates of a pair
  double sum = 0;
  for (const int i : items)
    sum += std::min(squared_px2[static_cast<std::size_t>(i)] / (sigma_px * sigma_px), 2 * (kMeasured - dimension));
  const auto count = static_cast<double>(items.size());
  return sum + std::log(kMeasured) * dimension * count + std::log(kMeasured * count) * parameters;
}

double breadth_px(const std::vector<Eigen::Vector2d>& points, std::span<const int> items) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const int i : items) mean += points[static_cast<std::size_t>(i)];
  mean /= static_cast<double>(items.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const int i : items) {
    const Eigen::Vector2d d = points[static_cast<std::size_t>(i)] - mean;
    scatter += d * d.transpose();
  }
  scatter /= static_cast<double>(items.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(scatter, Eigen::EigenvaluesOnly);
  return std::sqrt(std::max(0.0, eigen.eigenvalues()(0)));
}

double distance_from_rotation(const Eigen::Matrix3d& h) {
  const double scale = std::cbrt(std::abs(h.determinant()));
  if (!(scale > 0)) return std::numeric_limits<double>::infinity();
  return (h.transpose() * h / (scale * scale) - Eigen::Matrix3d::Identity()).norm();
}

bool beyond_chance(const std::vector<Eigen::Vector2d>& second_px, std::size_t inliers, double threshold_px) {
  if (second_px.empty()) return false;
  Eigen::Vector2d low = second_px.front(), high = low;
  for (const Eigen::Vector2d& p : second_px) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const Eigen::Vector2d extent = (high - low).cwiseMax(1.0);
  const double band = 2 * std::sqrt(2.0) * threshold_px * extent.norm() / (extent.x() * extent.y());
  const std::size_t count = second_px.size();
  constexpr std::size_t kSample = 5, kModels = 10;
  if (inliers <= kSample || inliers > count) return false;
  const double log_alarms = std::log(static_cast<double>(kModels * count)) + log_choose(count, inliers) +
                            log_choose(inliers, kSample) +
                            static_cast<double>(inliers - kSample) * std::log(std::min(band, 0.5));
  return log_alarms < kLogFalseAlarms;
}

std::vector<Match> without_marks(std::span<const Keypoint> first, std::span<const Keypoint> second,
                                 std::span<const Match> matches) {
  std::vector<Match> moving;
  std::size_t slow = 0;
  for (const Match& match : matches) {
    const double distance_px = moved_px(first, second, match);
    slow += distance_px >= kStill_px && distance_px < kSlow_px;
    if (distance_px >= kStill_px) moving.push_back(match);
  }
  const std::size_t still = matches.size() - moving.size();
  if (still < kLeastMarks || still <= kStillForEachSlow * slow) return {matches.begin(), matches.end()};
  return moving;
}

bool nearly_all_still(std::span<const Keypoint> first, std::span<const Keypoint> second,
                      std::span<const Match> matches) {
  const auto still = std::count_if(matches.begin(), matches.end(),
                                   [&](const Match& match) { return moved_px(first, second, match) < kStill_px; });
  return static_cast<double>(still) > kNearlyAll * static_cast<double>(matches.size());
}

std::vector<int> most_alike(std::span<const RotationAndScale> changes) {
  std::array<std::array<int, kScaleCells>, kRotationCells> votes{};
  for (const RotationAndScale& change : changes) {
    const auto [rotation, scale] = cell_of(change);
    ++votes[static_cast<std::size_t>(rotation)][static_cast<std::size_t>(scale)];
  }
  std::vector<std::pair<int, int>> ranked;  // minus the votes, item: unique, so that the order is too
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const auto [rotation, scale] = cell_of(changes[i]);
    int sum = 0;
    for (int dt = -1; dt <= 1; ++dt)
      for (int ds = -1; ds <= 1; ++ds)
        sum += votes[static_cast<std::size_t>(wrapped(rotation + dt))][static_cast<std::size_t>(scale + ds)];
    ranked.push_back({-sum, static_cast<int>(i)});
  }
  const std::size_t count = changes.size() / 3;
  std::nth_element(ranked.begin(), ranked.begin() + static_cast<std::ptrdiff_t>(count), ranked.end());
  std::vector<int> items;
  for (std::size_t i = 0; i < count; ++i) items.push_back(ranked[i].second);
  std::sort(items.begin(), items.end());
  return items;
}

}  // namespace collinea
