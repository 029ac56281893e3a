// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "collinea/surface/height_interpolation.h"

namespace collinea {
namespace {

constexpr std::size_t kFewestPoints = 16;
constexpr double kMostCoefficients = 250'000, kMostWithSigma = 2500;
constexpr double kStiffness = 1e-4;  // weight of a second difference, of the mean weight of points on a coefficient

using Sparse = Eigen::SparseMatrix<double>;

// The four cubic B-splines that are not zero at the part u in [0, 1] of a square.
std::array<double, 4> b_splines(double u) {
  const double v = 1 - u;
  return {v * v * v / 6, (3 * u * u * u - 6 * u * u + 4) / 6, (3 * v * v * v - 6 * v * v + 4) / 6, u * u * u / 6};
}

// Squares of a grid with one coefficient more than squares, and one beyond, on either side.
struct SplineGrid {
  Eigen::Vector2d corner;
  double spacing_m;
  int across, down;  // coefficients

  [[nodiscard]] Eigen::Index count() const { return Eigen::Index(across) * down; }

  // Index of the first coefficient on a position's square, and the weights of its 16; nothing outside.
  [[nodiscard]] bool weights(const Eigen::Vector2d& on_map, std::array<std::pair<int, double>, 16>& found) const {
    const Eigen::Vector2d at = (on_map - corner) / spacing_m;
    if (!(at.x() >= 0 && at.y() >= 0 && at.x() <= across - 3 && at.y() <= down - 3)) return false;
    const int x = std::min(int(at.x()), across - 4), y = std::min(int(at.y()), down - 4);
    const auto along_x = b_splines(at.x() - x), along_y = b_splines(at.y() - y);
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i)
        found[std::size_t(4 * j + i)] = {(y + j) * across + x + i, along_x[std::size_t(i)] * along_y[std::size_t(j)]};
    return true;
  }
};

class BicubicSplines : public HeightInterpolation {
 public:
  BicubicSplines(const SplineGrid& grid, double level, Eigen::VectorXd coefficients, Eigen::MatrixXd covariance)
      : grid_(grid), level_(level), coefficients_(std::move(coefficients)), covariance_(std::move(covariance)) {}

  [[nodiscard]] InterpolatedHeight at(const Eigen::Vector2d& on_map) const override {
    std::array<std::pair<int, double>, 16> weights;
    if (!grid_.weights(on_map, weights)) return {};
    InterpolatedHeight answer;
    answer.height_m = level_;
    for (const auto& [index, weight] : weights) answer.height_m += weight * coefficients_[index];
    if (covariance_.size() == 0) return answer;
    double variance = 0;
    for (const auto& [i, a] : weights)
      for (const auto& [j, b] : weights) variance += a * b * covariance_(i, j);
    answer.sigma_m = std::sqrt(std::max(variance, 0.0));
    return answer;
  }

 private:
  SplineGrid grid_;
  double level_;
  Eigen::VectorXd coefficients_;
  Eigen::MatrixXd covariance_;  // empty: not known
};

// Second differences of the coefficients along both axes, each with a weight.
void add_stiffness(const SplineGrid& grid, double weight, std::vector<Eigen::Triplet<double>>& entries) {
  const auto add = [&](int first, int step) {
    const int at[] = {first, first + step, first + 2 * step};
    const double values[] = {1, -2, 1};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) entries.emplace_back(at[i], at[j], weight * values[i] * values[j]);
  };
  for (int y = 0; y < grid.down; ++y)
    for (int x = 0; x < grid.across; ++x) {
      if (x + 2 < grid.across) add(y * grid.across + x, 1);
      if (y + 2 < grid.down) add(y * grid.across + x, grid.across);
    }
}

SplineGrid grid_round(std::span<const HeightPoint> points, double spacing_m) {
  Eigen::Vector2d low = points[0].position.head<2>(), high = low;
  for (const HeightPoint& point : points) {
    low = low.cwiseMin(point.position.head<2>());
    high = high.cwiseMax(point.position.head<2>());
  }
  const auto coefficients = [&](double extent_m) { return int(std::min(std::ceil(extent_m / spacing_m), 1e6)) + 3; };
  return {low, spacing_m, std::max(coefficients(high.x() - low.x()), 4), std::max(coefficients(high.y() - low.y()), 4)};
}

// Normal equations of the points alone, of heights above a level.
struct PointNormals {
  Sparse matrix;
  Eigen::VectorXd right;
  double squares = 0, weights = 0;
};

PointNormals normals_of(std::span<const HeightPoint> points, const SplineGrid& grid, double level) {
  PointNormals normals;
  const Eigen::Index count = grid.count();
  normals.right = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Triplet<double>> entries;
  std::array<std::pair<int, double>, 16> row;
  for (const HeightPoint& point : points) {
    if (!grid.weights(point.position.head<2>(), row)) continue;
    const double weight = point.sigma_m > 0 ? 1 / (point.sigma_m * point.sigma_m) : 1.0;
    const double height = point.position.z() - level;
    normals.weights += weight;
    normals.squares += weight * height * height;
    for (const auto& [i, a] : row) {
      normals.right[i] += weight * a * height;
      for (const auto& [j, b] : row) entries.emplace_back(i, j, weight * a * b);
    }
  }
  normals.matrix = Sparse(count, count);
  normals.matrix.setFromTriplets(entries.begin(), entries.end());
  return normals;
}

Sparse stiffness(const SplineGrid& grid, double weight) {
  std::vector<Eigen::Triplet<double>> entries;
  add_stiffness(grid, weight, entries);
  Sparse matrix(grid.count(), grid.count());
  matrix.setFromTriplets(entries.begin(), entries.end());
  return matrix;
}

// By the scatter of the points and as many unknowns as they effectively determine; empty: not known.
Eigen::MatrixXd covariance_of(const Eigen::SimplicialLDLT<Sparse>& factors, const PointNormals& normals,
                              const Eigen::VectorXd& coefficients, std::size_t points) {
  const Eigen::Index count = coefficients.size();
  if (double(count) > kMostWithSigma) return {};
  const Eigen::MatrixXd unit = Eigen::MatrixXd::Identity(count, count);
  const Eigen::MatrixXd by_points = factors.solve(unit) * normals.matrix;
  const double effective = by_points.trace();
  const double left =
      normals.squares - 2 * coefficients.dot(normals.right) + coefficients.dot(normals.matrix * coefficients);
  if (!(double(points) > effective + 1)) return {};
  return std::max(left, 0.0) / (double(points) - effective) * (by_points * factors.solve(unit));
}

}  // namespace

Result<std::unique_ptr<HeightInterpolation>> bicubic_splines(std::span<const HeightPoint> points, double spacing_m) {
  if (points.size() < kFewestPoints)
    return fail(Errc::kIllPosed, fmt::format("splines need {} points; there are {}", kFewestPoints, points.size()));
  const SplineGrid grid = grid_round(points, spacing_m);
  if (double(grid.across) * grid.down > kMostCoefficients)
    return fail(Errc::kBadInput, fmt::format("squares of {} m make {} x {} coefficients, more than {}", spacing_m,
                                             grid.across, grid.down, kMostCoefficients));
  double level = 0;
  for (const HeightPoint& point : points) level += point.position.z() / double(points.size());
  const PointNormals normals = normals_of(points, grid, level);
  const Sparse all = normals.matrix + stiffness(grid, kStiffness * normals.weights / double(grid.count()));
  const Eigen::SimplicialLDLT<Sparse> factors(all);
  if (factors.info() != Eigen::Success || !(factors.vectorD().minCoeff() > 0))
    return fail(Errc::kIllPosed, "the points do not determine the splines: they lie on a line");
  Eigen::VectorXd coefficients = factors.solve(normals.right);
  Eigen::MatrixXd covariance = covariance_of(factors, normals, coefficients, points.size());
  return std::make_unique<BicubicSplines>(grid, level, std::move(coefficients), std::move(covariance));
}

}  // namespace collinea
