// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/space_resection.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/epipolar/intersect_rays.h"
#include "collinea/epipolar/p3p.h"
#include "collinea/geometry/plane.h"
#include "collinea/geometry/rotation.h"
#include "collinea/math/median.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr double kLeastEigenvalue = 1e-12;

// A mark linearised and divided by its sigma.
struct Linear {
  Matrix26 by_pose;
  Matrix23 by_point;
  Vector2d misfit;
};

// A point with its own normal matrix and the images that see it.
struct Eliminated {
  Matrix3d inverse = Matrix3d::Zero();  // of its normal matrix
  Vector3d right = Vector3d::Zero();
  std::vector<std::pair<std::size_t, Eigen::Matrix<double, 6, 3>>> with_pose;

  // As new, but with the memory it has.
  void reset() {
    inverse.setZero();
    right.setZero();
    with_pose.clear();
  }
};

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
      : camera_(camera), marks_(marks), given_(points), poses_(starts.begin(), starts.end()) {
    for (const ResectionPoint& point : points) points_.push_back(point.in_world);
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
      const std::vector<Rigid3> poses = poses_;
      const std::vector<Vector3d> all_points = points_;
      move(step);
      const double after = linearise(linear);
      if (!(after <= cost * (1 + 1e-12) + 1e-20)) {
        poses_ = poses;
        points_ = all_points;
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
  [[nodiscard]] bool is_exact(std::size_t point) const { return given_[point].is_exact(); }

  [[nodiscard]] Result<> check() {
    std::vector<int> rays(given_.size(), 0);
    std::vector<std::size_t> seen(poses_.size(), 0);
    redundancy_ = -6 * static_cast<int>(poses_.size());
    for (const ResectionMark& mark : marks_) {
      COLLINEA_CHECK(mark.image < poses_.size() && mark.point < given_.size());
      ++rays[mark.point];
      ++seen[mark.image];
      redundancy_ += 2;
    }
    for (const std::size_t count : seen)
      if (count < 3) return fail(Errc::kIllPosed, "an image needs three points, there are " + std::to_string(count));
    for (std::size_t p = 0; p < given_.size(); ++p) {
      if (rays[p] == 0 || is_exact(p)) continue;
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
      for (const ResectionMark& mark : marks_)
        if (mark.point == p) {
          from.push_back(poses_[mark.image]);
          xy.push_back(normalized(camera_, mark.pixel));
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
      row.by_pose << row.by_point * skew(arm), -row.by_point;
      row.misfit = (mark.pixel - *pixel) / mark.sigma_px;
      cost += row.misfit.squaredNorm();
    }
    for (std::size_t p = 0; p < given_.size(); ++p)
      if (!is_exact(p)) cost += whitened(p).squaredNorm();
    return std::isfinite(cost) ? cost : std::numeric_limits<double>::infinity();
  }
  // What is given of a point minus what it is now, over the sigmas; 0 of what is free.
  [[nodiscard]] Vector3d whitened(std::size_t p) const {
    Vector3d out = Vector3d::Zero();
    for (int axis = 0; axis < 3; ++axis)
      if (const double sigma = sigma_of(p, axis); std::isfinite(sigma))
        out[axis] = (given_[p].in_world[axis] - points_[p][axis]) / sigma;
    return out;
  }
  // Of a point that is exact in one coordinate and measured in another the first is known to a micrometre.
  [[nodiscard]] double sigma_of(std::size_t p, int axis) const { return std::max(1e-6, given_[p].sigma_m[axis]); }

  // Reduced normal equations of the poses; false when they leave something open.
  [[nodiscard]] bool reduce(double damping) {
    const auto size = 6 * static_cast<Eigen::Index>(poses_.size());
    MatrixXd normal = MatrixXd::Zero(size, size);
    right_ = VectorXd::Zero(size);
    eliminated_.resize(given_.size());
    for (Eliminated& point : eliminated_) point.reset();
    for (std::size_t p = 0; p < given_.size(); ++p) {
      if (is_exact(p)) continue;
      for (int axis = 0; axis < 3; ++axis)
        if (const double sigma = sigma_of(p, axis); std::isfinite(sigma))
          eliminated_[p].inverse(axis, axis) = 1 / (sigma * sigma);
      const Vector3d residual = whitened(p);
      for (int axis = 0; axis < 3; ++axis)
        if (residual[axis] != 0) eliminated_[p].right[axis] = residual[axis] / sigma_of(p, axis);
    }
    for (std::size_t i = 0; i < marks_.size(); ++i) {
      const auto image = static_cast<Eigen::Index>(marks_[i].image);
      normal.block<6, 6>(6 * image, 6 * image) += linear_[i].by_pose.transpose() * linear_[i].by_pose;
      right_.segment<6>(6 * image) += linear_[i].by_pose.transpose() * linear_[i].misfit;
      if (is_exact(marks_[i].point)) continue;
      Eliminated& point = eliminated_[marks_[i].point];
      point.inverse += linear_[i].by_point.transpose() * linear_[i].by_point;
      point.right += linear_[i].by_point.transpose() * linear_[i].misfit;
      point.with_pose.emplace_back(marks_[i].image, linear_[i].by_pose.transpose() * linear_[i].by_point);
    }
    for (std::size_t p = 0; p < given_.size(); ++p) {
      Eliminated& point = eliminated_[p];
      if (point.with_pose.empty()) continue;
      const Eigen::LDLT<Matrix3d> factor(point.inverse);
      if (!(factor.vectorD().minCoeff() > 1e-14 * point.inverse.trace())) return false;  // no depth
      point.inverse = factor.solve(Matrix3d::Identity());
      for (const auto& [a, with_a] : point.with_pose) {
        right_.segment<6>(6 * static_cast<Eigen::Index>(a)) -= with_a * (point.inverse * point.right);
        for (const auto& [b, with_b] : point.with_pose)
          normal.block<6, 6>(6 * static_cast<Eigen::Index>(a), 6 * static_cast<Eigen::Index>(b)) -=
              with_a * point.inverse * with_b.transpose();
      }
    }
    return invert(normal, damping);
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
      const Eliminated& point = eliminated_[p];
      if (point.with_pose.empty()) continue;
      Vector3d right = point.right;
      for (const auto& [a, with] : point.with_pose)
        right -= with.transpose() * step.segment<6>(6 * static_cast<Eigen::Index>(a));
      points_[p] += point.inverse * right;
    }
    for (std::size_t a = 0; a < poses_.size(); ++a) {
      const Vector6 by = step.segment<6>(6 * static_cast<Eigen::Index>(a));
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
    std::vector<std::vector<Eigen::Matrix<double, 6, 3>>> cross(points_.size());  // covariance of poses with a point
    for (std::size_t p = 0; p < points_.size(); ++p) add_point(p, cross[p], out);
    for (std::size_t i = 0; i < marks_.size(); ++i) out.marks.push_back(test_of(i, cross[marks_[i].point], out));
    for (std::size_t a = 0; a < poses_.size(); ++a) out.conditioning.push_back(conditioning_of(inverse_, a));
    return out;
  }
  void add_point(std::size_t p, std::vector<Eigen::Matrix<double, 6, 3>>& cross, SpaceResection& out) const {
    const Eliminated& point = eliminated_[p];
    if (point.with_pose.empty()) return;
    MatrixXd with = MatrixXd::Zero(inverse_.rows(), 3);
    for (const auto& [a, block] : point.with_pose) with.middleRows<6>(6 * static_cast<Eigen::Index>(a)) += block;
    const MatrixXd back = with * point.inverse, covariance = inverse_ * back;
    out.point_covariances[p] = point.inverse + back.transpose() * covariance;
    for (std::size_t a = 0; a < poses_.size(); ++a)
      cross.push_back(-covariance.middleRows<6>(6 * static_cast<Eigen::Index>(a)));
    const Vector3d residual = whitened(p);
    for (int axis = 0; axis < 3; ++axis) {
      const double sigma = sigma_of(p, axis);
      if (!std::isfinite(sigma)) continue;
      const double redundancy = 1 - out.point_covariances[p](axis, axis) / (sigma * sigma);
      if (redundancy > 1e-9) out.point_w[p][axis] = residual[axis] / std::sqrt(redundancy);
    }
  }
  [[nodiscard]] MarkTest test_of(std::size_t i, const std::vector<Eigen::Matrix<double, 6, 3>>& cross,
                                 const SpaceResection& out) const {
    const ResectionMark& mark = marks_[i];
    const auto at = 6 * static_cast<Eigen::Index>(mark.image);
    const Linear& row = linear_[i];
    Eigen::Matrix2d used = row.by_pose * inverse_.block<6, 6>(at, at) * row.by_pose.transpose();
    if (!cross.empty()) {
      const Eigen::Matrix2d mixed = row.by_pose * cross[mark.image] * row.by_point.transpose();
      used += mixed + mixed.transpose() + row.by_point * out.point_covariances[mark.point] * row.by_point.transpose();
    }
    MarkTest test;
    test.misfit = mark.sigma_px * row.misfit;
    for (int k = 0; k < 2; ++k) {
      test.redundancy[k] = std::max(0.0, 1 - used(k, k));
      if (test.redundancy[k] > 1e-9) test.w[k] = row.misfit[k] / std::sqrt(test.redundancy[k]);
    }
    return test;
  }
  const Camera& camera_;
  std::span<const ResectionMark> marks_;
  std::span<const ResectionPoint> given_;
  std::vector<Rigid3> poses_;
  std::vector<Vector3d> points_;
  std::vector<Linear> linear_;
  std::vector<Eliminated> eliminated_;
  MatrixXd inverse_;  // of the reduced normal matrix
  VectorXd right_;
  int redundancy_ = 0, iterations_ = 0;
};

// Squared errors in units of the image.
void squared_errors(const Rigid3& pose, double focal, std::span<const Vector2d> xy, std::span<const Vector3d> points,
                    std::vector<double>& out) {
  const Matrix3d r = pose.rotation.toRotationMatrix();
  out.resize(xy.size());
  for (std::size_t i = 0; i < xy.size(); ++i) {
    const Vector3d p = r * points[i] + pose.translation;
    out[i] = p.z() > 0 ? focal * focal * (p.head<2>() / p.z() - xy[i]).squaredNorm()
                       : std::numeric_limits<double>::infinity();
  }
}

// Calls visit with all triples below n, or with `most` drawn ones.
template <class Visit>
void for_triples(std::size_t n, std::size_t most, std::uint64_t seed, const Visit& visit) {
  if (n * (n - 1) * (n - 2) / 6 <= most) {
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = i + 1; j < n; ++j)
        for (std::size_t k = j + 1; k < n; ++k) visit({i, j, k});
    return;
  }
  Random random(seed);
  const auto below = static_cast<std::uint32_t>(n);
  for (std::size_t trial = 0; trial < most; ++trial) {
    const std::array<std::size_t, 3> t{random.below(below), random.below(below), random.below(below)};
    if (t[0] != t[1] && t[1] != t[2] && t[0] != t[2]) visit(t);
  }
}

}  // namespace

Result<SpaceResection> space_resection(const Camera& camera, std::span<const Rigid3> starts,
                                       std::span<const ResectionMark> marks, std::span<const ResectionPoint> points) {
  return Adjustment(camera, starts, marks, points).run();
}

std::vector<PoseStart> pose_starts(const Camera& camera, std::span<const Vector2d> pixels,
                                   std::span<const Vector3d> points_in_world, std::uint64_t seed, std::size_t most) {
  COLLINEA_CHECK(pixels.size() == points_in_world.size());
  if (pixels.size() < 3) return {};
  std::vector<Vector2d> xy;
  for (const Vector2d& pixel : pixels) xy.push_back(normalized(camera, pixel));
  const double focal = pixels_per_unit(camera, xy[0]);
  // The h-th smallest of n errors: half of them and half of a sample more (Rousseeuw and Leroy 1987).
  const std::size_t n = xy.size(), rank = std::min(n, n / 2 + 2) - 1;
  struct Candidate {
    Rigid3 pose;
    double criterion, sum;
  };
  std::vector<Candidate> found;
  std::vector<double> errors;
  for_triples(n, most, seed, [&](const std::array<std::size_t, 3>& triple) {
    std::array<Vector3d, 3> rays, points;
    for (std::size_t k = 0; k < 3; ++k) {
      rays[k] = Vector3d(xy[triple[k]].x(), xy[triple[k]].y(), 1).normalized();
      points[k] = points_in_world[triple[k]];
    }
    for (const Rigid3& pose : p3p(rays, points)) {
      squared_errors(pose, focal, xy, points_in_world, errors);
      std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(rank), errors.end());
      double sum = 0;
      for (std::size_t k = 0; k <= rank; ++k) sum += errors[k];
      if (std::isfinite(sum)) found.push_back({pose, n > 4 ? errors[rank] : sum, sum});
    }
  });
  if (n > 3)
    std::stable_sort(found.begin(), found.end(),
                     [](const Candidate& a, const Candidate& b) { return a.criterion < b.criterion; });
  std::vector<PoseStart> starts;
  for (const Candidate& candidate : found) {
    if (n > 3 && starts.size() == 4) break;
    const double scale = n > 3 ? 0.8493 * (1 + 5 / std::max(1.0, double(n) - 3)) * std::sqrt(candidate.criterion) : 0;
    starts.push_back({candidate.pose, scale});
  }
  return starts;
}

std::optional<DangerCylinder> danger_cylinder(std::span<const Vector3d> points_in_world,
                                              const Vector3d& centre_in_world) {
  const auto plane = fit_plane(points_in_world);
  if (!plane) return std::nullopt;
  const FramedPlane frame = framed_plane(plane->middle, plane->normal);
  // Circle x^2 + y^2 = 2 a x + 2 b y + c by least squares.
  Matrix3d normal = Matrix3d::Zero();
  Vector3d right = Vector3d::Zero();
  for (const Vector3d& point : points_in_world) {
    const Vector2d p = frame.in_plane(point).head<2>();
    const Vector3d row(2 * p.x(), 2 * p.y(), 1);
    normal += row * row.transpose();
    right += row * p.squaredNorm();
  }
  const Vector3d circle = normal.ldlt().solve(right);
  const double radius = std::sqrt(circle.z() + circle.head<2>().squaredNorm());
  if (!std::isfinite(radius)) return std::nullopt;
  double squares = 0;
  for (const Vector3d& point : points_in_world) {
    const Vector3d p = frame.in_plane(point);
    const double off = (p.head<2>() - circle.head<2>()).norm() - radius;
    squares += off * off + p.z() * p.z();
  }
  const Vector2d centre = frame.in_plane(centre_in_world).head<2>() - circle.head<2>();
  return DangerCylinder{radius, std::sqrt(squares / double(points_in_world.size())), centre.norm() - radius};
}

}  // namespace collinea
