// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/height_interpolation.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "collinea/geometry/delaunay.h"
#include "collinea/geometry/plane_squares.h"

namespace collinea {
namespace {

constexpr double kThinnest = 1e-6;  // of the extents of the nearest points: below, they lie on a line

class Triangulated : public HeightInterpolation {
 public:
  Triangulated(Delaunay triangles, std::span<const HeightPoint> points, double longest_m)
      : triangles_(std::move(triangles)), points_(points.begin(), points.end()), longest_m_(longest_m) {}

  [[nodiscard]] InterpolatedHeight at(const Eigen::Vector2d& on_map) const override {
    const auto found = triangles_.find(on_map);
    if (!found) return {};
    const auto& corners = triangles_.triangles()[std::size_t(found->triangle)].corners;
    if (longest_side_m(corners) > longest_m_) return {};
    InterpolatedHeight answer{0, 0};
    bool is_known = true;
    for (std::size_t i = 0; i < 3; ++i) {
      const HeightPoint& corner = points_[std::size_t(corners[i])];
      answer.height_m += found->weights[i] * corner.position.z();
      answer.sigma_m = std::hypot(answer.sigma_m, found->weights[i] * corner.sigma_m);
      is_known = is_known && corner.sigma_m > 0;
    }
    if (!is_known) answer.sigma_m = std::numeric_limits<double>::quiet_NaN();
    return answer;
  }

 private:
  [[nodiscard]] double longest_side_m(const std::array<int, 3>& corners) const {
    double longest_m = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector3d side =
          points_[std::size_t(corners[i])].position - points_[std::size_t(corners[(i + 1) % 3])].position;
      longest_m = std::max(longest_m, side.head<2>().norm());
    }
    return longest_m;
  }

  Delaunay triangles_;
  std::vector<HeightPoint> points_;
  double longest_m_;
};

class LocalPlanes : public HeightInterpolation {
 public:
  LocalPlanes(std::span<const HeightPoint> points, int nearest)
      : points_(points.begin(), points.end()), squares_(in_plan(points)), nearest_(std::size_t(nearest)) {}

  [[nodiscard]] InterpolatedHeight at(const Eigen::Vector2d& on_map) const override {
    const auto nearest = squares_.nearest(on_map, nearest_);
    const double middle_m = std::max((points_[nearest[nearest.size() / 2]].position.head<2>() - on_map).norm(), 1e-12);
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero(), spread = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    // Scatter is that of observations by their sigmas; nearer ones count more only in where the plane goes.
    double sum_squares = 0, sum_weights = 0;
    const double level = points_[nearest[0]].position.z();
    for (const std::size_t i : nearest) {
      const auto [row, weight] = row_of(points_[i], on_map, middle_m);
      normal += weight * row * row.transpose();
      right += weight * row * (points_[i].position.z() - level);
    }
    const Eigen::LDLT<Eigen::Matrix3d> factors(normal);
    if (!(factors.vectorD().minCoeff() > kThinnest * factors.vectorD().maxCoeff())) return {};
    const Eigen::Vector3d plane = factors.solve(right);
    for (const std::size_t i : nearest) {
      const auto [row, weight] = row_of(points_[i], on_map, middle_m);
      const double residual = points_[i].position.z() - level - row.dot(plane), variance = variance_of(points_[i]);
      sum_squares += residual * residual / variance;
      sum_weights += 1;
      spread += weight * weight * variance * row * row.transpose();
    }
    const Eigen::Vector3d weights_of_height = factors.solve(Eigen::Vector3d::UnitX());
    const double sigma0_2 = sum_squares / (sum_weights - 3);
    return {level + plane.x(), std::sqrt(sigma0_2 * weights_of_height.dot(spread * weights_of_height))};
  }

 private:
  static double variance_of(const HeightPoint& point) { return point.sigma_m > 0 ? point.sigma_m * point.sigma_m : 1; }

  // Row of the design matrix in units of the median distance, and the weight.
  static std::pair<Eigen::Vector3d, double> row_of(const HeightPoint& point, const Eigen::Vector2d& on_map,
                                                   double middle_m) {
    const Eigen::Vector2d from = (point.position.head<2>() - on_map) / middle_m;
    return {{1, from.x(), from.y()}, 1 / ((1 + from.squaredNorm()) * variance_of(point))};
  }

  std::vector<HeightPoint> points_;
  PlaneSquares squares_;
  std::size_t nearest_;
};

}  // namespace

Result<std::unique_ptr<HeightInterpolation>> triangulated(std::span<const HeightPoint> points, double longest_m) {
  auto triangles = Delaunay::of(in_plan(points));
  if (!triangles) return fail(Errc::kIllPosed, "triangles need three points or more that do not lie on one line");
  return std::make_unique<Triangulated>(std::move(*triangles), points, longest_m);
}

Result<std::unique_ptr<HeightInterpolation>> local_planes(std::span<const HeightPoint> points, int nearest) {
  if (nearest < 4 || points.size() < std::size_t(nearest))
    return fail(Errc::kIllPosed, "local planes need at least four points, and as many as each plane is to go through");
  return std::make_unique<LocalPlanes>(points, nearest);
}

}  // namespace collinea
