// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_exterior.h"

#include <algorithm>
#include <cmath>

#include "collinea/dense/working_images.h"
#include "collinea/epipolar/model_points.h"
#include "collinea/epipolar/pair_shape.h"
#include "collinea/geometry/rotation.h"
#include "collinea/jobs/internal/pair_cloud.h"
#include "collinea/jobs/internal/pair_sigma.h"
#include "collinea/jobs/internal/pose_estimates.h"

namespace collinea {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Poses = std::array<Rigid3, 2>;

constexpr double kRounding = 1e-12;  // [m, bases, deg]

Poses poses_by(const Rigid3& right_from_left, const Similarity3& ground_from_model) {
  return {moved(Rigid3{}, ground_from_model), moved(right_from_left, ground_from_model)};
}

Result<Poses> changed_poses(const ModelOfPair& model, const Vector5& change,
                            const std::optional<PairControl>& control) {
  Rigid3 right_from_left = changed(model.orientation.second_from_first, change);
  right_from_left.translation *= model.epipolar.base_m;
  if (!control) return poses_by(right_from_left, map_from_model(std::nullopt));
  COLLINEA_TRY(const AbsoluteOrientation absolute, oriented_absolutely(*control, model, right_from_left));
  return poses_by(right_from_left, absolute.ground_from_model);
}

// From one pose to another: rotation about the axes of the ground, and shift of the centre.
Vector6 difference(const Rigid3& to, const Rigid3& from) {
  Vector6 out;
  out << rotation_vector((to.rotation.conjugate() * from.rotation).normalized()), centre_of(to) - centre_of(from);
  return out;
}

// Of a pose by the parameters of the similarity (AbsoluteOrientation::covariance).
Eigen::Matrix<double, 6, 7> by_similarity(const Rigid3& pose, const AbsoluteOrientation& absolute) {
  const Eigen::Vector3d arm = centre_of(pose) - absolute.ground_from_model * absolute.centroid_in_model;
  Eigen::Matrix<double, 6, 7> by = Eigen::Matrix<double, 6, 7>::Zero();
  by.block<3, 3>(0, 3).setIdentity();
  by.block<3, 3>(3, 0).setIdentity();
  by.block<3, 3>(3, 3) << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
  by.block<3, 1>(3, 6) = arm;
  return by;
}

}  // namespace

RelativeReport relative_report_of(const PairOrientation& last, const PairFiles& pair, const RelativeOptions& options,
                                  std::optional<double> base_m, bool is_given) {
  RelativeReport report;
  report.is_given = is_given;
  report.frame.camera = pair.cameras[0];
  report.second_principal_distance = pair.cameras[1].focal_px();
  const Camera left = shrunk(pair.cameras[0], last.shrink), right = shrunk(pair.cameras[1], last.shrink);
  report.points = normalised(last.matched, left, right, 1);
  for (std::size_t i = 0; i < last.matched.size(); ++i) report.names.push_back(std::to_string(i + 1));
  report.options = options;
  report.sigma = last.shrink;
  report.base_is_given = base_m.has_value();
  report.base = base_m.value_or(1);
  report.orientation = last.orientation;
  std::vector<PairPoint> used;
  for (std::size_t i = 0; i < report.points.size(); ++i)
    if (last.orientation.residuals[i].used) used.push_back(report.points[i]);
  report.solutions = relative_solutions(last.orientation.second_from_first, used);
  report.shape = pair_shape(last.orientation.second_from_first, used, last.orientation.normal);
  report.model = model_points(last.orientation, report.points, report.base, true);
  return report;
}

Result<std::array<UncertainPose, 2>> exterior_poses(const ModelOfPair& model, const std::optional<PairControl>& control,
                                                    const std::optional<AbsoluteOrientation>& absolute) {
  const Matrix5 relative = model.orientation.stated_covariance();
  const Poses poses = poses_by(model.right_from_left(), map_from_model(absolute));
  std::array<Eigen::Matrix<double, 6, 5>, 2> by;
  const Vector5 steps = difference_steps(model.orientation);
  for (int i = 0; i < 5; ++i) {
    const double step = steps[i];
    COLLINEA_TRY(const Poses more, changed_poses(model, step * Vector5::Unit(i), control));
    COLLINEA_TRY(const Poses less, changed_poses(model, -step * Vector5::Unit(i), control));
    for (std::size_t k = 0; k < 2; ++k) by[k].col(i) = difference(more[k], less[k]) / (2 * step);
  }
  std::array<UncertainPose, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    out[k] = {poses[k], by[k] * relative * by[k].transpose()};
    if (!absolute) continue;
    const Eigen::Matrix<double, 6, 7> of_similarity = by_similarity(poses[k], *absolute);
    out[k].covariance += of_similarity * absolute->covariance * of_similarity.transpose();
  }
  return out;
}

std::array<PairExterior, 2> pair_exterior(const std::array<UncertainPose, 2>& poses, const PairFiles& pair,
                                          bool is_metric) {
  std::array<PairExterior, 2> out;
  for (std::size_t k = 0; k < 2; ++k) {
    out[k].image = pair.files[k].filename().string();
    out[k].elements = estimates_of_pose(poses[k].cam_from_world);
    if (poses[k].covariance.norm() > 0) {  // otherwise it is exact
      out[k].covariance = covariance_of_estimates(poses[k].cam_from_world, poses[k].covariance);
      add_sigmas(out[k].elements, out[k].covariance.diagonal().cwiseMax(0).asDiagonal());
    }
    for (Estimate& element : out[k].elements) {
      if (element.unit == "m" && !is_metric) element.unit = "";
      if (std::abs(element.value) < kRounding) element.value = 0;  // of the datum
    }
  }
  return out;
}

}  // namespace collinea
