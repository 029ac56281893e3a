// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/levelled.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kQuadratic = 1;  // sigmas up to which the loss is that of least squares
constexpr int kMostRounds = 100;
constexpr double kStable = 0.01;  // of the usual sigma, by which the plane still moves at the end

using Plane = Eigen::Vector3d;  // error in the middle, and by the length of the area to the east and north

class Levelling {
 public:
  explicit Levelling(const std::vector<LocatedError>& errors) : errors_(errors) {
    std::vector<float> sigmas;
    for (const LocatedError& one : errors) {
      middle_ += Eigen::Vector2d(one.east_m, one.north_m) / double(errors.size());
      sigmas.push_back(one.sigma_m);
    }
    usual_sigma_m_ = double(median(sigmas));
    for (const LocatedError& one : errors)
      length_m_ = std::max({length_m_, std::abs(one.east_m - middle_.x()), std::abs(one.north_m - middle_.y())});
  }

  // Absolute values beyond a sigma, squares below it (Huber): that has one minimum wherever it begins, to which gross
  // errors pull no more than small ones. Then least squares of those that are not gross.
  [[nodiscard]] std::optional<Plane> plane() const {
    const auto first = fitted(Plane::Zero(), [](double) { return 1.0; });
    const auto robust = until_stable(first, [](double sigmas) { return std::min(1.0, kQuadratic / sigmas); });
    return until_stable(robust, [](double sigmas) { return sigmas <= kGrossSigmas ? 1.0 : 0.0; });
  }

  [[nodiscard]] double of(const Plane& plane, const LocatedError& one) const { return row_of(one).dot(plane); }

 private:
  [[nodiscard]] Plane row_of(const LocatedError& one) const {
    return {1, (one.east_m - middle_.x()) / length_m_, (one.north_m - middle_.y()) / length_m_};
  }

  template <class Weight>
  [[nodiscard]] std::optional<Plane> until_stable(std::optional<Plane> plane, const Weight& weight) const {
    for (int round = 0; plane && round < kMostRounds; ++round) {
      const auto next = fitted(*plane, weight);
      const bool stable = next && (*next - *plane).cwiseAbs().sum() <= kStable * usual_sigma_m_;
      plane = next;
      if (stable) break;
    }
    return plane;
  }

  // Least squares; weight(how many sigmas an error is from the plane so far).
  template <class Weight>
  [[nodiscard]] std::optional<Plane> fitted(const Plane& so_far, const Weight& weight) const {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Plane right = Plane::Zero();
    for (const LocatedError& one : errors_) {
      const Plane row = row_of(one);
      const double sigma_m = std::max(double(one.sigma_m), usual_sigma_m_);
      const double w = weight(std::abs(double(one.error_m) - row.dot(so_far)) / sigma_m) / (sigma_m * sigma_m);
      normal += w * row * row.transpose();
      right += w * row * double(one.error_m);
    }
    const Eigen::LDLT<Eigen::Matrix3d> solved(normal);
    if (!(solved.vectorD().minCoeff() > 1e-9 * solved.vectorD().maxCoeff())) return std::nullopt;
    return solved.solve(right);
  }

  const std::vector<LocatedError>& errors_;
  Eigen::Vector2d middle_{0, 0};
  double length_m_ = 0, usual_sigma_m_ = 0;
};

}  // namespace

bool take_off_plane(std::vector<LocatedError>& errors) {
  if (errors.size() < 4) return false;
  const Levelling levelling(errors);
  const std::optional<Plane> plane = levelling.plane();
  if (!plane) return false;
  for (LocatedError& one : errors) one.error_m -= float(levelling.of(*plane, one));
  return true;
}

}  // namespace collinea
