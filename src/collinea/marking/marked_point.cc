// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/marked_point.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "collinea/epipolar/intersect.h"
#include "collinea/marking/local_poses.h"
#include "collinea/math/quantiles.h"

namespace collinea {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kFalseAlarm = 0.001, kPower = 0.8;

// The shift of w that is found with the power, by bisection.
double found_shift() {
  const double limit = normal_limit(kFalseAlarm);
  double low = 0, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (power_of_test(middle, limit) < kPower ? low : high) = middle;
  }
  return high;
}

/// Observation equations of all marks at a position.
struct Equations {
  MatrixXd by_point;    // 2 n x 3
  VectorXd misfit;      // measured minus computed
  MatrixXd covariance;  // of the measured pixels and of what the images' errors make of the computed ones
};

// The derivatives of a pixel by all that C is of.
void add_by_images(const Block& block, const JointPoses& images, std::size_t image, const LinearPixel& linear,
                   const Matrix2P& by_camera, Eigen::Ref<MatrixXd> row) {
  row.middleCols<6>(6 * Eigen::Index(image)) = linear.by_pose;
  auto column = 6 * Eigen::Index(images.images.size());
  for (const JointPoses::FreeCamera& camera : images.cameras) {
    const bool is_its = camera.camera == block.images.at(images.images[image]).camera;
    for (const int param : camera.params) {
      if (is_its) row.col(column) = by_camera.col(param);
      ++column;
    }
  }
}

std::optional<Equations> equations_at(const Block& block, const JointPoses& images, std::span<const PointMark> marks,
                                      const Vector3d& position) {
  const Eigen::Index count = 2 * Eigen::Index(marks.size());
  Equations e{MatrixXd(count, 3), VectorXd(count), MatrixXd::Zero(count, count)};
  MatrixXd by_images = MatrixXd::Zero(count, images.covariance.cols());
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const PointMark& mark = marks[i];
    const ImageId image = images.images[mark.image];
    Matrix2P by_camera;
    const auto linear = linear_pixel(block.camera_of(image), pose_of(block, image), position,
                                     images.cameras.empty() ? nullptr : &by_camera);
    if (!linear) return std::nullopt;
    const Eigen::Index row = 2 * Eigen::Index(i);
    e.by_point.middleRows<2>(row) = linear->by_point;
    e.misfit.segment<2>(row) = mark.pixel - linear->pixel;
    e.covariance.block<2, 2>(row, row) = mark.covariance;
    add_by_images(block, images, mark.image, *linear, by_camera, by_images.middleRows<2>(row));
  }
  e.covariance += by_images * images.covariance * by_images.transpose();
  return e;
}

std::optional<Vector3d> start_of(const Block& block, const JointPoses& images, std::span<const PointMark> marks) {
  std::vector<SightLine> lines;
  for (const PointMark& mark : marks) {
    const ImageId image = images.images[mark.image];
    lines.push_back(
        {&block.camera_of(image), pose_of(block, image), mark.pixel, std::sqrt(mark.covariance.trace() / 2), {}});
  }
  const auto found = intersect(lines);
  return found ? std::optional(found->point_in_world) : std::nullopt;
}

void add_tests(const Equations& e, const MatrixXd& weight, MarkedPoint& point) {
  static const double kShift = found_shift();
  const MatrixXd of_residuals = e.covariance - e.by_point * point.covariance * e.by_point.transpose();
  const MatrixXd redundancy = of_residuals * weight, of_multipliers = weight * redundancy;
  const VectorXd multipliers = weight * e.misfit;
  for (Eigen::Index row = 0; row < e.misfit.size(); row += 2) {
    PointMarkTest test{e.misfit.segment<2>(row),
                       {},
                       Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()),
                       Vector2d::Constant(std::numeric_limits<double>::infinity())};
    for (Eigen::Index k = 0; k < 2; ++k) {
      const Eigen::Index at = row + k;
      test.redundancy[k] = redundancy(at, at);
      if (!(of_multipliers(at, at) > 1e-9 * weight(at, at))) continue;
      test.w[k] = multipliers[at] / std::sqrt(of_multipliers(at, at));
      test.detectable_px[k] = kShift / std::sqrt(of_multipliers(at, at));
    }
    point.tests.push_back(test);
  }
}

}  // namespace

std::optional<MarkedPoint> marked_point(const Block& block, const JointPoses& images,
                                        std::span<const PointMark> marks) {
  constexpr int kMostIterations = 20;
  // Of a step in its standard deviations, squared; what rounding leaves of large coordinates is let pass in the end.
  constexpr double kSettled = 1e-14, kNearlySettled = 1e-6;
  if (marks.size() < 2) return std::nullopt;
  const auto start = start_of(block, images, marks);
  if (!start) return std::nullopt;
  MarkedPoint point{.position_in_world = *start, .redundancy = 2 * int(marks.size()) - 3};
  for (int iteration = 0; iteration < kMostIterations; ++iteration) {
    const auto e = equations_at(block, images, marks, point.position_in_world);
    if (!e) return std::nullopt;
    const Eigen::LLT<MatrixXd> factor(e->covariance);
    if (factor.info() != Eigen::Success) return std::nullopt;
    const MatrixXd weight = factor.solve(MatrixXd::Identity(e->misfit.size(), e->misfit.size()));
    const Matrix3d normal = e->by_point.transpose() * weight * e->by_point;
    const Eigen::LLT<Matrix3d> solver(normal);
    if (solver.info() != Eigen::Success) return std::nullopt;
    point.covariance = solver.solve(Matrix3d::Identity());
    point.gain = point.covariance * e->by_point.transpose() * weight;
    const Vector3d step = point.gain * e->misfit;
    if (!step.allFinite()) return std::nullopt;
    if (step.dot(normal * step) < (iteration + 1 < kMostIterations ? kSettled : kNearlySettled)) {
      point.sigma0 = std::sqrt(e->misfit.dot(weight * e->misfit) / point.redundancy);
      add_tests(*e, weight, point);
      return point;
    }
    point.position_in_world += step;
  }
  return std::nullopt;
}

}  // namespace collinea
