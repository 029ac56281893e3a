// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/ground_motion.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "collinea/math/median.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea::bundle {
namespace {

constexpr std::size_t kGroundPoints = 2000;

Eigen::Vector3d point_in_world(const State& state, std::size_t point) {
  return Eigen::Map<const Eigen::Vector3d>(&state.points[3 * point]);
}

// The variance of a point by its own rays, all else being exact; its trace [m^2].
double own_variance(const PointSystem& system) {
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) sum += system.solve_own(Eigen::Vector3d::Unit(axis))[axis];
  return sum;
}

// A point that stands for the ground, with its equations.
struct Member {
  PointSystem system;
  int first_retained;
};

/// Gathers the points, then the equations of their motion.
class GroundFit {
 public:
  GroundFit(const Problem& problem, const State& state) : problem_(problem), state_(state) {
    take_points();
    if (motion_.points.size() >= 3) measure();
  }

  // False where the points do not tell all motions.
  [[nodiscard]] bool find_inverse() {
    if (motion_.points.size() < 3 || !(motion_.size > 0)) return false;
    for (const GroundMotion::Point& one : motion_.points) {
      const Matrix37 g = derivatives(one);
      normals_ += one.weight * g.transpose() * g;
    }
    const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(normals_);
    if (!(eigen.eigenvalues()[0] > kSeenMotion * eigen.eigenvalues()[6])) return false;
    inverse_ = normals_.inverse();
    return true;
  }

  [[nodiscard]] GroundMotion solved(const TileCholesky& factor) {
    Columns by_reduced;
    by_reduced.fill(Eigen::VectorXd::Zero(Eigen::Index(factor.tile_rows()) * kTile));
    Matrix7 covariance = Matrix7::Zero();
    for (std::size_t i = 0; i < members_.size(); ++i) add(i, by_reduced, covariance);
    Columns with = by_reduced;
    for (std::size_t k = 0; k < 7; ++k) {
      factor.solve(with[k].data());
      for (std::size_t i = 0; i < 7; ++i) covariance(Eigen::Index(i), Eigen::Index(k)) += by_reduced[i].dot(with[k]);
    }
    motion_.observed = without_unseen();
    motion_.covariance = motion_.observed * covariance * motion_.observed.transpose();
    return std::move(motion_);
  }

 private:
  using Columns = std::array<Eigen::VectorXd, 7>;

  void take_points() {
    std::vector<std::size_t> candidates;
    for (std::size_t p = 0; p < problem_.point_count(); ++p)
      if (!problem_.point(p).is_fixed && problem_.point(p).first_free < problem_.end_ray(p)) candidates.push_back(p);
    const std::size_t step = (candidates.size() + kGroundPoints - 1) / kGroundPoints;
    std::vector<double> variances;
    for (std::size_t k = 0; k < candidates.size(); k += step) {
      const std::size_t p = candidates[k];
      PointSystem system(problem_, state_, p);
      if (!system.determined()) continue;
      variances.push_back(own_variance(system));
      motion_.points.push_back({p, 1});
      members_.push_back({std::move(system), problem_.point(p).first_retained});
    }
    if (variances.empty()) return;
    const double typical = median(variances);
    for (std::size_t i = 0; i < variances.size(); ++i) motion_.points[i].weight = std::min(1.0, typical / variances[i]);
  }

  void measure() {
    double weights = 0, squared = 0;
    motion_.centre.setZero();
    for (const auto& [number, weight] : motion_.points) {
      motion_.centre += weight * point_in_world(state_, number);
      weights += weight;
    }
    motion_.centre /= weights;
    for (const auto& [number, weight] : motion_.points)
      squared += weight * (point_in_world(state_, number) - motion_.centre).squaredNorm();
    motion_.size = std::sqrt(squared / weights);
  }

  [[nodiscard]] Matrix37 derivatives(const GroundMotion::Point& point) const {
    return motion_.size * motion_of(point_in_world(state_, point.number), motion_.centre, motion_.size);
  }

  // What a point adds to T by the reduced unknowns, and to its covariance by its own rays.
  void add(std::size_t i, Columns& by_reduced, Matrix7& own) const {
    const Member& member = members_[i];
    const Matrix37 part = motion_.points[i].weight * derivatives(motion_.points[i]) * inverse_;
    for (Eigen::Index k = 0; k < 7; ++k) {
      Eigen::VectorXd& column = by_reduced[static_cast<std::size_t>(k)];
      if (member.first_retained >= 0) {
        column.segment<3>(6 * problem_.poses + member.first_retained) += part.col(k);
        continue;
      }
      member.system.add_following(part.col(k), column);
      own.col(k) += part.transpose() * member.system.solve_own(part.col(k));
    }
  }

  // I - D (D'MD)^-1 D'M, D being the motions that nothing observes.
  [[nodiscard]] Matrix7 without_unseen() const {
    const auto count = static_cast<Eigen::Index>(problem_.datum.size());
    if (count == 0) return Matrix7::Identity();
    Eigen::MatrixXd unseen(7, count);
    for (Eigen::Index k = 0; k < count; ++k) {
      const DatumConstraint& one = problem_.datum[static_cast<std::size_t>(k)];
      unseen.col(k) = one.motion;
      unseen.col(k).head<3>() = one.size / motion_.size * motion_of(motion_.centre, one.centre, one.size) * one.motion;
    }
    const Eigen::MatrixXd weighted = unseen.transpose() * normals_;
    return Matrix7::Identity() - unseen * (weighted * unseen).inverse() * weighted;
  }

  const Problem& problem_;
  const State& state_;
  std::vector<Member> members_;  // parallel to the points of the motion
  GroundMotion motion_;
  Matrix7 normals_ = Matrix7::Zero(), inverse_ = Matrix7::Zero();
};

}  // namespace

Vector7 GroundMotion::fitted_to(const State& state, const std::vector<Eigen::Vector3d>& errors) const {
  Matrix7 normals = Matrix7::Zero();
  Vector7 right = Vector7::Zero();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Matrix37 g = size * motion_of(point_in_world(state, points[i].number), centre, size);
    normals += points[i].weight * g.transpose() * g;
    right += points[i].weight * g.transpose() * errors[i];
  }
  return observed * normals.ldlt().solve(right);
}

std::optional<GroundMotion> ground_motion(const Problem& problem, const State& state, const TileCholesky& factor) {
  GroundFit fit(problem, state);
  if (!fit.find_inverse()) return {};
  return fit.solved(factor);
}

}  // namespace collinea::bundle
