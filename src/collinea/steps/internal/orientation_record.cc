// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/orientation_record.h"

#include <algorithm>
#include <cmath>

#include "collinea/epipolar/intersect.h"
#include "collinea/quality/mark_check.h"
#include "collinea/quality/variance_components.h"
#include "collinea/report/statistics.h"

namespace collinea {
namespace {

// Root mean square per axis; nothing without a single difference.
std::optional<AxisValues> rms_by_axis(const std::vector<Eigen::Vector3d>& differences_m) {
  const AxisRms rms = rms_of(differences_m);
  return rms.points ? std::optional(rms.axis_m) : std::nullopt;
}

// The difference without the axes that were not measured.
Eigen::Vector3d measured_axes(Eigen::Vector3d difference_m, const Eigen::Vector3d& sigma_m) {
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(sigma_m[axis])) difference_m[axis] = std::nan("");
  return difference_m;
}

std::optional<AxisValues> control_rms(const Orientation& orientation, bool used) {
  std::vector<Eigen::Vector3d> differences_m;
  for (const ControlDifference& control : orientation.adjusted.control)
    if (control.used == used && control.position_in_world && !orientation.excluded_control.contains(control.point))
      differences_m.push_back(control.difference_m);
  return rms_by_axis(differences_m);
}

std::vector<PositionDifference> positions_of(const Orientation& orientation) {
  std::vector<PositionDifference> positions = orientation.adjusted.positions;
  for (PositionDifference& position : positions)
    position.difference_m =
        measured_axes(position.difference_m, orientation.block.images.at(position.image).position->sigma_m);
  return positions;
}

std::optional<AxisValues> position_rms(const std::vector<PositionDifference>& positions) {
  std::vector<Eigen::Vector3d> differences_m;
  for (const PositionDifference& position : positions) differences_m.push_back(position.difference_m);
  return rms_by_axis(differences_m);
}

double mean_residual_px(const Adjusted& adjusted) {
  double sum = 0;
  std::size_t count = 0;
  for (const Eigen::Vector2d& residual : adjusted.residuals_px)
    if (residual.allFinite()) {
      sum += residual.norm();
      ++count;
    }
  return count ? sum / double(count) : 0;
}

// Control that was found wrong took no part: its differences, seen with its measurements as they were given.
std::vector<ControlDifference> excluded_control(const Orientation& orientation, const Block& setup) {
  Block measured;
  measured.cameras = orientation.block.cameras;
  measured.images = setup.images;
  measured.poses = orientation.block.poses;
  measured.control_observations = setup.control_observations;
  correct_marks(orientation.findings, measured);
  remove_marks_outside(measured);
  std::vector<ControlDifference> excluded;
  for (const ControlId id : orientation.excluded_control) {
    const ControlPoint& point = orientation.block.control.at(id);
    const std::vector<SightLine> lines = sight_lines(measured, id);
    ControlDifference& its = excluded.emplace_back();
    its.point = id;
    its.excluded = true;
    its.rays = static_cast<int>(lines.size());
    if (const auto met = intersect(lines)) {
      its.position_in_world = met->point_in_world;
      its.difference_m = measured_axes(met->point_in_world - point.position_in_world, point.sigma_m);
    }
  }
  return excluded;
}

std::vector<GeodeticDifference> geodetic_of(const Orientation& orientation) {
  std::vector<GeodeticDifference> geodetic = orientation.adjusted.geodetic;
  for (GeodeticDifference& one : geodetic) one.excluded = orientation.excluded_geodetic.contains(one.observation);
  return geodetic;
}

// Where the covariance gives no number nothing is kept.
std::vector<HeightPrecision> height_precision_of(const Examined& adjusted) {
  std::vector<HeightPrecision> list;
  for (const PointPrecision& precision : adjusted.point_precisions) {
    const double sigma_m = std::sqrt(std::max(0.0, precision.covariance_m2(2, 2))) * sigma_scale(adjusted);
    if (std::isfinite(sigma_m)) list.push_back({precision.position_in_world.head<2>(), sigma_m});
  }
  return list;
}

CalibrationRecord calibration_of(const Orientation& orientation) {
  CalibrationRecord record;
  record.parameters = orientation.calibration.parameters;
  for (const auto& [camera, params] : orientation.calibration.free)
    record.free[camera].assign(params.begin(), params.end());
  const double scale = sigma_scale(orientation.adjusted);
  for (const auto& [camera, covariance] : orientation.adjusted.camera_covariance) {
    std::vector<double>& sigma = record.sigma[camera];
    const Eigen::VectorXd values = covariance.diagonal().cwiseSqrt() * scale;
    for (const double value : values) sigma.push_back(std::isfinite(value) ? value : 0);
  }
  return record;
}

}  // namespace

OrientationRecord record_of(const Orientation& orientation, const Block& setup) {
  const Examined& adjusted = orientation.adjusted;
  OrientationRecord record;
  record.images = setup.images.size();
  record.oriented = count_oriented(orientation.block);
  record.tie_points = orientation.block.points.size();
  record.observations = orientation.block.observations.size();
  record.gross_measurements = std::uint64_t(orientation.gross_measurements);
  record.mean_reprojection_px = mean_residual_px(adjusted);
  record.pixel_size = orientation.gsd_m;
  record.sigma0 = adjusted.sigma0;
  record.redundancy = adjusted.redundancy;
  record.georeferenced = orientation.georeferenced;
  record.metric = orientation.metric;
  record.relative_heights = orientation.relative_heights;
  record.holds_given_poses = orientation.holds_given_poses;
  record.gauge = orientation.gauge;
  record.control_rmse_m = control_rms(orientation, true);
  record.check_rmse_m = control_rms(orientation, false);
  record.positions = positions_of(orientation);
  record.position_rms_m = position_rms(record.positions);
  record.sigma_factors = factors_by_word(orientation.sigma_factors);
  record.position_shift_m = orientation.position_shift_m;
  record.instruments = orientation.instruments;
  record.calibration = calibration_of(orientation);
  record.not_oriented = orientation.alone;
  record.other_parts = orientation.other_parts;
  record.control = adjusted.control;
  for (ControlDifference& excluded : excluded_control(orientation, setup)) record.control.push_back(excluded);
  record.geodetic = geodetic_of(orientation);
  record.height_precision = height_precision_of(adjusted);
  for (const auto& [image, covariance] : adjusted.pose_covariance)
    record.centre_sigma_m[image] = covariance.diagonal().tail<3>().cwiseSqrt() * sigma_scale(adjusted);
  record.findings = orientation.findings;
  return record;
}

}  // namespace collinea
