// SPDX-License-Identifier: Apache-2.0
#include "ceres_bundle.h"

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <array>
#include <cmath>
#include <ctime>
#include <map>

#include "collinea/adjust/bundle.h"
#include "collinea/geometry/rotation.h"

namespace collinea::bench {
namespace {

constexpr int kLens = 8;  // f cx cy k1 k2 k3 p1 p2, as in Camera::params

// Angle-axis and centre of a pose; the mathematics of camera/camera.h without affinity, with analytic derivatives.
class ImagePoint : public ceres::SizedCostFunction<2, 6, kLens, 3> {
 public:
  explicit ImagePoint(const Observation& seen)
      : u_(seen.pixel.x()), v_(seen.pixel.y()), inverse_sigma_(1 / seen.sigma_px) {}

  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    const Eigen::Map<const Eigen::Vector3d> angle(blocks[0]), centre(blocks[0] + 3), point(blocks[2]);
    const double* lens = blocks[1];
    const Eigen::Vector3d d = point - centre;
    double r[9];
    ceres::AngleAxisToRotationMatrix(angle.data(), r);
    const Eigen::Map<const Eigen::Matrix3d> rotation(r);
    const Eigen::Vector3d p = rotation * d;
    const double x = p[0] / p[2], y = p[1] / p[2], r2 = x * x + y * y;
    const double radial = 1 + r2 * (lens[3] + r2 * (lens[4] + r2 * lens[5]));
    const double xd = x * radial + lens[6] * (r2 + 2 * x * x) + 2 * lens[7] * x * y;
    const double yd = y * radial + lens[7] * (r2 + 2 * y * y) + 2 * lens[6] * x * y;
    residual[0] = (lens[1] + lens[0] * xd - u_) * inverse_sigma_;
    residual[1] = (lens[2] + lens[0] * yd - v_) * inverse_sigma_;
    if (!jacobians) return true;
    const double scale = lens[0] * inverse_sigma_;
    const double slope = 2 * (lens[3] + r2 * (2 * lens[4] + 3 * r2 * lens[5]));  // of radial, by x over x
    Eigen::Matrix2d by_image;
    by_image(0, 0) = radial + slope * x * x + 6 * lens[6] * x + 2 * lens[7] * y;
    by_image(0, 1) = slope * x * y + 2 * lens[6] * y + 2 * lens[7] * x;
    by_image(1, 0) = by_image(0, 1);
    by_image(1, 1) = radial + slope * y * y + 6 * lens[7] * y + 2 * lens[6] * x;
    Eigen::Matrix<double, 2, 3> by_camera;
    by_camera << 1 / p[2], 0, -x / p[2], 0, 1 / p[2], -y / p[2];
    const Eigen::Matrix<double, 2, 3> by_point = scale * by_image * by_camera * rotation;
    if (jacobians[0]) {
      Eigen::Map<Eigen::Matrix<double, 2, 6, Eigen::RowMajor>> by_pose(jacobians[0]);
      by_pose.leftCols<3>() = -by_point * cross(d) * right_jacobian(angle);
      by_pose.rightCols<3>() = -by_point;
    }
    if (jacobians[1]) {
      const double s = inverse_sigma_, x_radial = scale * x * r2, y_radial = scale * y * r2;
      const double rows[2][kLens] = {
          {s * xd, s, 0, x_radial, x_radial * r2, x_radial * r2 * r2, scale * (r2 + 2 * x * x), scale * 2 * x * y},
          {s * yd, 0, s, y_radial, y_radial * r2, y_radial * r2 * r2, scale * 2 * x * y, scale * (r2 + 2 * y * y)}};
      std::copy_n(&rows[0][0], 2 * kLens, jacobians[1]);
    }
    if (jacobians[2]) {
      Eigen::Map<Eigen::Matrix<double, 2, 3, Eigen::RowMajor>> target(jacobians[2]);
      target = by_point;
    }
    return true;
  }

 private:
  static Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
    Eigen::Matrix3d m;
    m << 0, -v[2], v[1], v[2], 0, -v[0], -v[1], v[0], 0;
    return m;
  }
  // R(w + e) = R(w) R(J e)
  static Eigen::Matrix3d right_jacobian(const Eigen::Vector3d& w) {
    const double angle = w.norm();
    const Eigen::Matrix3d m = cross(w);
    if (angle < 1e-4) return Eigen::Matrix3d::Identity() - 0.5 * m;
    return Eigen::Matrix3d::Identity() - (1 - std::cos(angle)) / (angle * angle) * m +
           (angle - std::sin(angle)) / (angle * angle * angle) * m * m;
  }
  double u_, v_, inverse_sigma_;
};

struct Position {
  Eigen::Vector3d given, inverse_sigma;

  template <class T>
  bool operator()(const T* pose, T* residual) const {
    for (int i = 0; i < 3; ++i) residual[i] = (pose[3 + i] - given[i]) * inverse_sigma[i];
    return true;
  }
};

struct WeakLens {
  std::array<double, kLens> given, inverse_sigma;

  template <class T>
  bool operator()(const T* lens, T* residual) const {
    for (int i = 0; i < kLens; ++i) residual[i] = (lens[i] - given[i]) * inverse_sigma[i];
    return true;
  }
};

WeakLens weak_lens(const Camera& camera) {
  const double centre = 1 / (0.03 * camera.width_px);
  WeakLens weak;
  std::copy_n(camera.params.begin(), kLens, weak.given.begin());
  weak.inverse_sigma = {1 / camera.prior.sigma_f_px, centre, centre, 1 / 0.2, 1 / 0.5, 1 / 0.5, 1 / 0.01, 1 / 0.01};
  return weak;
}

class Watch : public ceres::IterationCallback {
 public:
  explicit Watch(double wanted_cost) : wanted_cost_(wanted_cost), begin_(cpu_seconds()) {}
  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override {
    if (2 * summary.cost > wanted_cost_) return ceres::SOLVER_CONTINUE;
    seconds = elapsed();
    return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
  }
  [[nodiscard]] double elapsed() const { return cpu_seconds() - begin_; }
  double seconds = -1;

 private:
  double wanted_cost_, begin_;
};

ceres::Solver::Options options_for(CeresSolver solver, int threads, const AdjustOptions& ours) {
  ceres::Solver::Options options;
  options.linear_solver_type = solver == CeresSolver::kDense    ? ceres::DENSE_SCHUR
                               : solver == CeresSolver::kSparse ? ceres::SPARSE_SCHUR
                                                                : ceres::ITERATIVE_SCHUR;
  options.preconditioner_type = ceres::SCHUR_JACOBI;
  options.num_threads = threads;
  options.max_num_iterations = ours.max_iterations;
  options.function_tolerance = ours.relative_cost_change;
  options.gradient_tolerance = options.parameter_tolerance = 0;
  options.logging_type = ceres::SILENT;
  return options;
}

}  // namespace

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

CeresOutcome ceres_bundle(const Block& block, const Block& first_cameras, CeresSolver solver, int threads,
                          double wanted_cost) {
  std::map<ImageId, std::array<double, 6>> poses;
  std::map<CameraId, std::array<double, kLens>> lenses;
  std::map<PointId, Eigen::Vector3d> points;
  for (const auto& [id, pose] : oriented_images(block)) {
    const Eigen::Vector3d rotation = rotation_vector(pose.rotation), centre = centre_of(pose);
    poses[id] = {rotation.x(), rotation.y(), rotation.z(), centre.x(), centre.y(), centre.z()};
  }
  for (const auto& [id, camera] : block.cameras) std::copy_n(camera.params.begin(), kLens, lenses[id].begin());
  for (const auto& [id, point] : block.points) points[id] = point.position_in_world;

  const AdjustOptions ours;
  ceres::Problem problem;
  auto* order = new ceres::ParameterBlockOrdering;
  auto* tie_loss = new ceres::HuberLoss(ours.loss_scale_sigmas);
  auto* position_loss = new ceres::HuberLoss(ours.position_loss_scale_sigmas);
  for (const Observation& seen : block.observations)
    problem.AddResidualBlock(new ImagePoint(seen), tie_loss, poses.at(seen.image).data(),
                             lenses.at(block.images.at(seen.image).camera).data(), points.at(seen.point).data());
  for (const auto& [id, pose] : oriented_images(block))
    if (const auto& position = block.images.at(id).position)
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Position, 3, 6>(
                                   new Position{position->position_in_world, position->sigma_m.cwiseInverse()}),
                               position_loss, poses.at(id).data());
  for (auto& [id, lens] : lenses)
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<WeakLens, kLens, kLens>(new WeakLens(weak_lens(first_cameras.cameras.at(id)))),
        nullptr, lens.data());
  for (auto& [id, point] : points) order->AddElementToGroup(point.data(), 0);
  for (auto& [id, pose] : poses) order->AddElementToGroup(pose.data(), 1);
  for (auto& [id, lens] : lenses) order->AddElementToGroup(lens.data(), 1);

  ceres::Solver::Options options = options_for(solver, threads, ours);
  options.linear_solver_ordering.reset(order);
  Watch watch(wanted_cost);
  options.callbacks.push_back(&watch);
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  CeresOutcome outcome;
  outcome.seconds = watch.elapsed();
  outcome.reached = watch.seconds >= 0;
  outcome.seconds_to_cost = outcome.reached ? watch.seconds : outcome.seconds;
  outcome.iterations = static_cast<int>(summary.iterations.size()) - 1;
  outcome.final_cost = 2 * summary.final_cost;
  outcome.jacobian_seconds = summary.jacobian_evaluation_time_in_seconds;
  outcome.linear_seconds = summary.linear_solver_time_in_seconds;
  return outcome;
}

}  // namespace collinea::bench
