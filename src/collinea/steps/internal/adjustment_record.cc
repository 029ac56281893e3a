// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/adjustment_record.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/epipolar/intersect.h"
#include "collinea/orient/adjusted_findings.h"
#include "collinea/quality/mark_check.h"
#include "collinea/quality/residual_tests.h"
#include "collinea/quality/systematic_findings.h"
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

std::optional<AxisValues> control_rms(const std::vector<ControlDifference>& controls, bool used) {
  std::vector<Eigen::Vector3d> differences_m;
  for (const ControlDifference& control : controls)
    if (control.used == used && control.position_in_world && !control.excluded)
      differences_m.push_back(control.difference_m);
  return rms_by_axis(differences_m);
}

std::vector<PositionDifference> positions_of(const Adjustment& adjustment) {
  std::vector<PositionDifference> positions = adjustment.adjusted.positions;
  for (PositionDifference& position : positions)
    position.difference_m =
        measured_axes(position.difference_m, adjustment.block.images.at(position.image).position->sigma_m);
  return positions;
}

std::optional<AxisValues> position_rms(const std::vector<PositionDifference>& positions) {
  std::vector<Eigen::Vector3d> differences_m;
  for (const PositionDifference& position : positions) differences_m.push_back(position.difference_m);
  return rms_by_axis(differences_m);
}

// Control that was found wrong took no part: its differences, seen with its measurements as they were given.
std::vector<ControlDifference> excluded_control(const Adjustment& adjustment, const OrientationRecord& orientation,
                                                const Block& setup) {
  Block measured;
  measured.cameras = adjustment.block.cameras;
  measured.images = setup.images;
  measured.poses = adjustment.block.poses;
  measured.control_observations = setup.control_observations;
  correct_marks(orientation.findings, measured);
  remove_marks_outside(measured);
  std::vector<ControlDifference> excluded;
  for (const ControlId id : orientation.excluded_control) {
    const ControlPoint& point = adjustment.block.control.at(id);
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

// Those that took part, and those that orientation excluded; poses of another program were placed by some of them.
std::vector<ControlDifference> control_of(const Adjustment& adjustment, const OrientationRecord& orientation,
                                          const Block& setup) {
  const std::set<ControlId> excluded(orientation.excluded_control.begin(), orientation.excluded_control.end());
  const std::set<ControlId> in_datum(orientation.used_for_datum.begin(), orientation.used_for_datum.end());
  std::vector<ControlDifference> control;
  for (ControlDifference one : adjustment.adjusted.control) {
    if (excluded.contains(one.point) && !one.used) continue;
    one.used |= in_datum.contains(one.point);
    control.push_back(one);
  }
  const auto is_used = [&](ControlId id) {
    return std::ranges::any_of(control, [&](const ControlDifference& one) { return one.point == id; });
  };
  for (const ControlDifference& one : excluded_control(adjustment, orientation, setup))
    if (!is_used(one.point)) control.push_back(one);
  return control;
}

std::vector<GeodeticDifference> geodetic_of(const Adjustment& adjustment, const OrientationRecord& orientation) {
  std::vector<GeodeticDifference> geodetic = adjustment.adjusted.geodetic;
  for (GeodeticDifference& one : geodetic)
    one.excluded = std::ranges::count(orientation.excluded_geodetic, one.observation) > 0;
  return geodetic;
}

// Where the covariance gives no number nothing is kept.
std::vector<PositionPrecision> position_precision_of(const Examined& adjusted) {
  std::vector<PositionPrecision> list;
  for (const PointPrecision& precision : adjusted.point_precisions)
    if (precision.covariance_m2.allFinite()) list.push_back({precision.position_in_world, precision.covariance_m2});
  return list;
}

CalibrationRecord calibration_of(const Adjustment& adjustment, Calibration calibration) {
  CalibrationRecord record;
  for (const auto& [id, camera] : adjustment.adjusted.cameras) {
    if (camera.prior.film) continue;
    const auto own = adjustment.scope.camera_sigmas.find(id);
    const CameraSigmas sigmas =
        own != adjustment.scope.camera_sigmas.end() ? own->second : calibration_sigmas(calibration, camera);
    for (const int param : params_of(camera))
      if (sigmas[std::size_t(param)] > 0) record.free[id].push_back(static_cast<std::uint32_t>(param));
  }
  if (!record.free.empty()) record.parameters = calibration;
  const double scale = sigma_scale(adjustment.adjusted);
  for (const auto& [camera, covariance] : adjustment.adjusted.camera_covariance) {
    std::vector<double>& sigma = record.sigma[camera];
    const Eigen::VectorXd values = covariance.diagonal().cwiseSqrt() * scale;
    for (const double value : values) sigma.push_back(std::isfinite(value) ? value : 0);
  }
  return record;
}

SigmaFactors sigma_factors_of(const Adjustment& adjustment, const OrientationRecord& orientation) {
  SigmaFactors factors = factors_of(orientation.sigma_factors);
  if (adjustment.components)
    for (std::size_t i = 0; i < factors.size(); ++i) factors[i] *= adjustment.components->factors[i];
  return factors;
}

std::vector<Finding> findings_of(const Adjustment& adjustment, const OrientationRecord& orientation,
                                 const Block& setup) {
  const std::set<std::size_t> excluded(orientation.excluded_geodetic.begin(), orientation.excluded_geodetic.end());
  std::vector<Finding> findings = adjusted_findings(adjustment.block, adjustment.adjusted, setup.cameras, excluded);
  const auto add = [&](const std::vector<Finding>& more) { findings.insert(findings.end(), more.begin(), more.end()); };
  add(adjustment.taken_up);
  add(systematic_findings(adjustment.adjusted.systematics, adjustment.block));
  add(residual_findings(adjustment.residual_tests));
  if (adjustment.snooped) add(rejected_findings(*adjustment.snooped));
  return findings;
}

}  // namespace

AdjustmentRecord record_of(const Adjustment& adjustment, const OrientationRecord& orientation, const Block& setup,
                           Calibration calibration) {
  const Examined& adjusted = adjustment.adjusted;
  AdjustmentRecord record;
  record.images = count_oriented(adjustment.block);
  record.tie_points = adjustment.block.points.size();
  record.observations = adjustment.block.observations.size();
  record.mismatches = adjustment.mismatches ? adjustment.mismatches->size() : 0;
  record.rejected = adjustment.snooped ? adjustment.snooped->rejected.size() : 0;
  record.mean_reprojection_px = mean_length_px(adjusted.residuals_px);
  record.sigma0 = adjusted.sigma0;
  record.redundancy = adjusted.redundancy;
  record.unknowns = adjusted.unknown_count;
  record.rank_defect = adjusted.rank_defect;
  record.control = control_of(adjustment, orientation, setup);
  record.control_rmse_m = control_rms(record.control, true);
  record.check_rmse_m = control_rms(record.control, false);
  record.positions = positions_of(adjustment);
  record.position_rms_m = position_rms(record.positions);
  record.sigma_factors = factors_by_word(sigma_factors_of(adjustment, orientation));
  record.instruments = adjustment.instruments;
  record.refraction = adjustment.refracted.has_value();
  record.calibration = calibration_of(adjustment, calibration);
  record.geodetic = geodetic_of(adjustment, orientation);
  record.position_precision = position_precision_of(adjusted);
  for (const auto& [image, covariance] : adjusted.pose_covariance) {
    const Eigen::Matrix<double, 6, 1> sigma = covariance.diagonal().cwiseSqrt() * sigma_scale(adjusted);
    record.rotation_sigma_rad[image] = sigma.head<3>();
    record.centre_sigma_m[image] = sigma.tail<3>();
  }
  record.findings = findings_of(adjustment, orientation, setup);
  return record;
}

BlockCovariances covariances_of(const Adjustment& adjustment) {
  BlockCovariances covariances;
  for (const auto& [image, covariance] : adjustment.adjusted.pose_covariance) covariances.poses[image] = covariance;
  for (const auto& [camera, covariance] : adjustment.adjusted.camera_covariance)
    covariances.cameras[camera] = covariance;
  covariances.points = adjustment.adjusted.point_covariance;
  return covariances;
}

}  // namespace collinea
