// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/space_resection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/epipolar/intersect_rays.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/inverse_root.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix26 = Eigen::Matrix<double, 2, 6, Eigen::RowMajor>;
using Eigen::Matrix2d;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kLeastEigenvalue = 1e-12;
constexpr double kAtRest = 1e-5;  // step in standard deviations by which nothing changes

// A mark linearised and divided by its sigma.
struct Linear {
  Matrix26 by_pose;
  Matrix23 by_point;
  Vector2d misfit;
};

// A point with its own normal equations.
struct Eliminated {
  Matrix3d inverse = Matrix3d::Zero();  // of its normal matrix
  Vector3d right = Vector3d::Zero();
};

// The marks of each point, in their order.
class MarksOfPoints {
 public:
  MarksOfPoints(std::span<const ResectionMark> marks, std::size_t points)
      : begins_(points + 1, 0), marks_(marks.size()) {
    for (const ResectionMark& mark : marks) ++begins_[mark.point + 1];
    for (std::size_t p = 0; p < points; ++p) begins_[p + 1] += begins_[p];
    std::vector<std::size_t> next(begins_.begin(), begins_.end() - 1);
    for (std::size_t i = 0; i < marks.size(); ++i) marks_[next[marks[i].point]++] = i;
  }
  [[nodiscard]] std::span<const std::size_t> operator[](std::size_t point) const {
    return std::span(marks_).subspan(begins_[point], begins_[point + 1] - begins_[point]);
  }

 private:
  std::vector<std::size_t> begins_, marks_;
};

// What is given of a point that is not exact; of a free coordinate zero, and no weight.
struct Known {
  Vector3d in_world = Vector3d::Zero(), inverse_sigma = Vector3d::Zero();
};

// Of a point that is exact in one coordinate and measured in another the first is known to a micrometre.
Known known_of(const ResectionPoint& point) {
  Known known;
  for (int axis = 0; axis < 3; ++axis)
    if (std::isfinite(point.sigma_m[axis])) {
      known.in_world[axis] = point.in_world[axis];
      known.inverse_sigma[axis] = 1 / std::max(1e-6, point.sigma_m[axis]);
    }
  return known;
}

PoseConditioning conditioning_of(const MatrixXd& covariance, std::size_t image) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const auto at = 6 * static_cast<Eigen::Index>(image);
  const Matrix6 normal = Matrix6(covariance.block<6, 6>(at, at)).ldlt().solve(Matrix6::Identity());
  const Vector6 scale = normal.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Matrix6> eigen(scale.asDiagonal() * normal * scale.asDiagonal());
  return {eigen.eigenvalues()[0] / eigen.eigenvalues()[5], eigen.eigenvectors().col(0)};
}

class Adjustment {
 public:
  Adjustment(const Camera& camera, std::span<const Rigid3> starts, std::span<const ResectionMark> marks,
             std::span<const ResectionPoint> points)
      : camera_(camera),
        marks_(marks),
        given_(points),
        of_point_(marks, points.size()),
        poses_(starts.begin(), starts.end()) {
    for (const ResectionPoint& point : points) {
      points_.push_back(point.in_world);
      exact_.push_back(point.is_exact());
      known_.push_back(known_of(point));
    }
  }

  [[nodiscard]] Result<SpaceResection> run() {
    COLLINEA_TRY(check());
    start_free_points();
    double cost = linearise(linear_);
    if (!std::isfinite(cost)) return fail(Errc::kIllPosed, "a control point lies behind the camera of the start");
    double damping = 0;
    std::vector<Linear> linear;
    for (iterations_ = 1; iterations_ <= 50; ++iterations_) {
      if (!reduce(damping)) return open();
      const VectorXd step = inverse_ * right_;
      // Undamped it is the squared length of the step in standard deviations: beyond this the cost is rounding alone.
      const bool is_at_rest = damping == 0 && step.dot(right_) < kAtRest * kAtRest;
      const std::vector<Rigid3> poses = poses_;
      const std::vector<Vector3d> all_points = points_;
      move(step);
      const double after = linearise(linear);
      if (!(after <= cost * (1 + 1e-12) + 1e-20)) {
        poses_ = poses;
        points_ = all_points;
        if (is_at_rest) return result(cost);
        damping = damping > 0 ? damping * 10 : 1e-4;
        if (damping > 1e8) break;
        continue;
      }
      const bool is_settled = cost - after <= 1e-12 * cost + 1e-20 && damping < 1e-6;
      linear_.swap(linear);
      cost = after;
      damping = damping > 1e-9 ? damping / 10 : 0;
      if (is_settled) return result(cost);
    }
    return fail(Errc::kNotConverged, "the resection does not converge");
  }

 private:
  [[nodiscard]] static tl::unexpected<Error> open() {
    return fail(Errc::kIllPosed,
                "the points do not determine the pose: they lie on a line, or with the projection centre on the danger "
                "cylinder");
  }
  [[nodiscard]] bool is_exact(std::size_t point) const { return exact_[point] != 0; }
  [[nodiscard]] static Eigen::Index at(std::size_t image) { return 6 * static_cast<Eigen::Index>(image); }

  [[nodiscard]] Result<> check() {
    std::vector<std::size_t> seen(poses_.size(), 0);
    redundancy_ = -6 * static_cast<int>(poses_.size());
    for (const ResectionMark& mark : marks_) {
      COLLINEA_CHECK(mark.image < poses_.size());
      ++seen[mark.image];
      redundancy_ += 2;
    }
    for (const std::size_t count : seen)
      if (count < 3) return fail(Errc::kIllPosed, "an image needs three points, there are " + std::to_string(count));
    for (std::size_t p = 0; p < given_.size(); ++p) {
      if (of_point_[p].empty() || is_exact(p)) continue;
      for (int axis = 0; axis < 3; ++axis) redundancy_ -= !std::isfinite(given_[p].sigma_m[axis]);
    }
    if (redundancy_ < 0) return fail(Errc::kIllPosed, "there are more unknowns than measurements");
    return {};
  }
  // Where their rays meet; others keep what was given of them.
  void start_free_points() {
    for (std::size_t p = 0; p < given_.size(); ++p) {
      if (given_[p].is_known()) continue;
      std::vector<Rigid3> from;
      std::vector<Vector2d> xy;
      for (const std::size_t i : of_point_[p]) {
        from.push_back(poses_[marks_[i].image]);
        xy.push_back(normalized(camera_, marks_[i].pixel));
      }
      if (const auto met = intersect_rays(from, xy))
        for (int axis = 0; axis < 3; ++axis)
          if (!std::isfinite(given_[p].sigma_m[axis])) points_[p][axis] = (*met)[axis];
    }
  }

  // Infinite when a point is not seen.
  double linearise(std::vector<Linear>& linear) const {
    linear.resize(marks_.size());
    std::vector<Matrix3d> rotations;
    std::vector<Vector3d> centres;
    for (const Rigid3& pose : poses_) {
      rotations.push_back(pose.rotation.toRotationMatrix());
      centres.push_back(centre_of(pose));
    }
    double cost = 0;
    for (std::size_t i = 0; i < marks_.size(); ++i) {
      const ResectionMark& mark = marks_[i];
      const Vector3d arm = points_[mark.point] - centres[mark.image];
      Matrix23 by_cam;
      const auto pixel = project(camera_, rotations[mark.image] * arm, &by_cam, nullptr);
      if (!pixel) return std::numeric_limits<double>::infinity();
      Linear& row = linear[i];
      row.by_point = by_cam * rotations[mark.image] / mark.sigma_px;
      for (int k = 0; k < 2; ++k) row.by_pose.row(k).head<3>() = row.by_point.row(k).cross(arm);
      row.by_pose.rightCols<3>() = -row.by_point;
      row.misfit = (mark.pixel - *pixel) / mark.sigma_px;
      cost += row.misfit.squaredNorm();
    }
    for (std::size_t p = 0; p < given_.size(); ++p)
      if (!is_exact(p)) cost += whitened(p).squaredNorm();
    return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
  }
  // What is given of a point minus what it is now, over the sigmas; 0 of what is free.
  [[nodiscard]] Vector3d whitened(std::size_t p) const {
    return (known_[p].in_world - points_[p]).cwiseProduct(known_[p].inverse_sigma);
  }

  // Reduced normal equations of the poses; false when they leave something open.
  [[nodiscard]] bool reduce(double damping) {
    MatrixXd normal = MatrixXd::Zero(at(poses_.size()), at(poses_.size()));
    right_ = VectorXd::Zero(normal.rows());
    eliminated_.resize(given_.size());
    gains_.resize(marks_.size());
    for (std::size_t p = 0; p < given_.size(); ++p) {
      if (of_point_[p].empty()) continue;
      if (!is_exact(p) && !solve_point(p)) return false;
      for (const std::size_t i : of_point_[p]) add_mark(i, normal);
    }
    return invert(normal, damping);
  }
  // The normal equations of a point by what is given of it and by its marks; false when these leave it open.
  [[nodiscard]] bool solve_point(std::size_t p) {
    Matrix3d normal = known_[p].inverse_sigma.cwiseAbs2().asDiagonal();
    Vector3d& right = eliminated_[p].right;
    right = whitened(p).cwiseProduct(known_[p].inverse_sigma);
    for (const std::size_t i : of_point_[p]) {
      normal.noalias() += linear_[i].by_point.transpose().lazyProduct(linear_[i].by_point);
      right.noalias() += linear_[i].by_point.transpose().lazyProduct(linear_[i].misfit);
    }
    Matrix3d root;
    if (!inverse_root(normal, root, 1e-14 * normal.trace())) return false;  // no depth
    Matrix3d& inverse = eliminated_[p].inverse;
    inverse.noalias() = root.transpose().lazyProduct(root);
    for (const std::size_t i : of_point_[p]) gains_[i].noalias() = linear_[i].by_point.lazyProduct(inverse);
    return true;
  }
  // A mark in the normal equations of its pose. Schur complement of its point: with A by the pose, B by the point and N
  // the normal matrix of the point, marks i and k leave  A_i' (I_ik - B_i N^-1 B_k') A_k.
  void add_mark(std::size_t i, MatrixXd& normal) {
    const Linear& row = linear_[i];
    const std::size_t p = marks_[i].point;
    const auto by_pose = row.by_pose.transpose();
    const Eigen::Index image = at(marks_[i].image);
    if (is_exact(p)) {
      normal.block<6, 6>(image, image).noalias() += by_pose.lazyProduct(row.by_pose);
      right_.segment<6>(image).noalias() += by_pose.lazyProduct(row.misfit);
      return;
    }
    const Vector2d misfit = row.misfit - gains_[i].lazyProduct(eliminated_[p].right);
    right_.segment<6>(image).noalias() += by_pose.lazyProduct(misfit);
    for (const std::size_t k : of_point_[p]) {
      Matrix2d weight = -gains_[i].lazyProduct(linear_[k].by_point.transpose());
      if (k == i) weight += Matrix2d::Identity();
      const Matrix26 weighted = weight.lazyProduct(linear_[k].by_pose);
      normal.block<6, 6>(image, at(marks_[k].image)).noalias() += by_pose.lazyProduct(weighted);
    }
  }
  [[nodiscard]] bool invert(const MatrixXd& normal, double damping) {
    const VectorXd scale = normal.diagonal().cwiseSqrt().cwiseInverse();
    if (!scale.allFinite()) return false;
    const MatrixXd unit = scale.asDiagonal() * normal * scale.asDiagonal();
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(unit);
    if (!(eigen.eigenvalues()[0] > kLeastEigenvalue)) return false;
    const VectorXd values = (eigen.eigenvalues().array() + damping).inverse();
    inverse_ = scale.asDiagonal() * eigen.eigenvectors() * values.asDiagonal() * eigen.eigenvectors().transpose() *
               scale.asDiagonal();
    return true;
  }
  void move(const VectorXd& step) {
    for (std::size_t p = 0; p < given_.size(); ++p) {
      if (is_exact(p) || of_point_[p].empty()) continue;
      Vector3d change = eliminated_[p].inverse * eliminated_[p].right;
      for (const std::size_t i : of_point_[p]) {
        const Vector2d by_pose = linear_[i].by_pose.lazyProduct(step.segment<6>(at(marks_[i].image)));
        change -= gains_[i].transpose() * by_pose;
      }
      points_[p] += change;
    }
    for (std::size_t a = 0; a < poses_.size(); ++a) {
      const Vector6 by = step.segment<6>(at(a));
      const Vector3d centre = centre_of(poses_[a]) + by.tail<3>();
      poses_[a].rotation = (poses_[a].rotation * rotation_by(-by.head<3>())).normalized();
      poses_[a].translation = -(poses_[a].rotation * centre);
    }
  }

  [[nodiscard]] Result<SpaceResection> result(double cost) {
    if (!reduce(0)) return open();
    SpaceResection out;
    out.cam_from_world = poses_;
    out.covariance = inverse_;
    out.points = points_;
    out.redundancy = redundancy_;
    out.iterations = iterations_;
    if (redundancy_ > 0) out.sigma0 = std::sqrt(cost / redundancy_);
    out.point_covariances.assign(points_.size(), Matrix3d::Zero());
    out.point_w.assign(points_.size(), Vector3d::Zero());
    out.marks.resize(marks_.size());
    with_point_.resize(marks_.size());
    for (std::size_t p = 0; p < points_.size(); ++p) {
      if (is_exact(p))
        for (const std::size_t i : of_point_[p]) out.marks[i] = test_of(i, variance_by_pose(i));
      else
        add_point(p, out);
    }
    for (std::size_t a = 0; a < poses_.size(); ++a) out.conditioning.push_back(conditioning_of(inverse_, a));
    return out;
  }
  // A point with its marks: its covariance, and what is tested by it. Computed coordinates of marks i and k have by
  // their poses the covariance Q = A_i C A_k', by which the covariance of the point grows and its own with them is.
  void add_point(std::size_t p, SpaceResection& out) {
    const std::span<const std::size_t> marks = of_point_[p];
    if (marks.empty()) return;
    Matrix3d& covariance = out.point_covariances[p];
    covariance = eliminated_[p].inverse;
    for (const std::size_t i : marks) {
      with_point_[i].setZero();
      for (const std::size_t k : marks) with_point_[i].noalias() += by_poses(i, k).lazyProduct(gains_[k]);
      covariance.noalias() += gains_[i].transpose().lazyProduct(with_point_[i]);
    }
    for (const std::size_t i : marks) {
      const Matrix23& by_point = linear_[i].by_point;
      const Matrix23 both = by_point.lazyProduct(covariance) - 2 * with_point_[i];
      out.marks[i] = test_of(i, variance_by_pose(i) + both.cwiseProduct(by_point).rowwise().sum());
    }
    const Vector3d residual = whitened(p);
    for (int axis = 0; axis < 3; ++axis) {
      const double weight = known_[p].inverse_sigma[axis] * known_[p].inverse_sigma[axis];
      const double redundancy = 1 - covariance(axis, axis) * weight;
      if (redundancy > 1e-9) out.point_w[p][axis] = residual[axis] / std::sqrt(redundancy);
    }
  }
  // Covariance of the computed coordinates of two marks by their poses, in units of their own.
  [[nodiscard]] Matrix2d by_poses(std::size_t i, std::size_t k) const {
    const Matrix26 with =
        linear_[i].by_pose.lazyProduct(inverse_.block<6, 6>(at(marks_[i].image), at(marks_[k].image)));
    return with.lazyProduct(linear_[k].by_pose.transpose());
  }
  [[nodiscard]] Vector2d variance_by_pose(std::size_t i) const { return by_poses(i, i).diagonal(); }
  [[nodiscard]] MarkTest test_of(std::size_t i, const Vector2d& variance) const {
    MarkTest test;
    test.misfit = marks_[i].sigma_px * linear_[i].misfit;
    for (int k = 0; k < 2; ++k) {
      test.redundancy[k] = std::max(0.0, 1 - variance[k]);
      if (test.redundancy[k] > 1e-9) test.w[k] = linear_[i].misfit[k] / std::sqrt(test.redundancy[k]);
    }
    return test;
  }

  const Camera& camera_;
  std::span<const ResectionMark> marks_;
  std::span<const ResectionPoint> given_;
  MarksOfPoints of_point_;
  std::vector<std::uint8_t> exact_;
  std::vector<Known> known_;
  std::vector<Rigid3> poses_;
  std::vector<Vector3d> points_;
  std::vector<Linear> linear_;
  std::vector<Eliminated> eliminated_;
  std::vector<Matrix23> gains_;       // of each mark: its derivatives by its point times the point's inverse
  std::vector<Matrix23> with_point_;  // of each mark: sum of Q_ik times the gain of k
  MatrixXd inverse_;                  // of the reduced normal matrix
  VectorXd right_;
  int redundancy_ = 0, iterations_ = 0;
};

}  // namespace

Result<SpaceResection> space_resection(const Camera& camera, std::span<const Rigid3> starts,
                                       std::span<const ResectionMark> marks, std::span<const ResectionPoint> points) {
  for (const ResectionMark& mark : marks) COLLINEA_CHECK(mark.point < points.size());
  return Adjustment(camera, starts, marks, points).run();
}

}  // namespace collinea
