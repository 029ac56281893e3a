// SPDX-License-Identifier: Apache-2.0
#include "collinea/compare/levelled.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <optional>

namespace collinea {
namespace {

using Plane = Eigen::Vector3d;  // error at the middle, and by 100 m to the east and north

Plane row_of(const PlacedError& one, const Eigen::Vector2d& middle) {
  return {1, (one.east_m - middle.x()) / 100, (one.north_m - middle.y()) / 100};
}

std::optional<Plane> plane_of(const std::vector<PlacedError>& errors, const Eigen::Vector2d& middle,
                              const std::optional<Plane>& first) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Plane right = Plane::Zero();
  for (const PlacedError& one : errors) {
    const Plane row = row_of(one, middle);
    if (first && !(std::abs(one.error_m - row.dot(*first)) <= kGrossSigmas * double(one.sigma_m))) continue;
    normal += row * row.transpose();
    right += row * double(one.error_m);
  }
  const Eigen::LDLT<Eigen::Matrix3d> solved(normal);
  if (!(solved.vectorD().minCoeff() > 1e-9 * solved.vectorD().maxCoeff())) return std::nullopt;
  return solved.solve(right);
}

}  // namespace

bool take_off_plane(std::vector<PlacedError>& errors) {
  if (errors.size() < 4) return false;
  Eigen::Vector2d middle(0, 0);
  for (const PlacedError& one : errors) middle += Eigen::Vector2d(one.east_m, one.north_m);
  middle /= double(errors.size());
  std::optional<Plane> plane = plane_of(errors, middle, std::nullopt);
  if (plane) plane = plane_of(errors, middle, plane);
  if (!plane) return false;
  for (PlacedError& one : errors) one.error_m -= float(row_of(one, middle).dot(*plane));
  return true;
}

}  // namespace collinea
