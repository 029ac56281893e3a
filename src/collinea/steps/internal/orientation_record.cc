// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/orientation_record.h"

#include "collinea/quality/variance_components.h"
#include "collinea/report/statistics.h"

namespace collinea {

OrientationRecord record_of(const Orientation& orientation) {
  const Adjusted& adjusted = orientation.adjusted;
  OrientationRecord record;
  record.images = orientation.block.images.size();
  record.oriented = count_oriented(orientation.block);
  record.tie_points = orientation.block.points.size();
  record.observations = orientation.block.observations.size();
  record.gross_measurements = std::uint64_t(orientation.gross_measurements);
  record.mean_reprojection_px = mean_length_px(adjusted.residuals_px);
  record.pixel_size = orientation.gsd_m;
  record.georeferenced = orientation.georeferenced;
  record.metric = orientation.metric;
  record.relative_heights = orientation.relative_heights;
  record.holds_given_poses = orientation.holds_given_poses;
  record.gauge = orientation.gauge;
  record.used_positions = !adjusted.positions.empty();
  for (const ControlDifference& control : adjusted.control) {
    record.used_control |= control.used;
    if (control.used && orientation.holds_given_poses) record.used_for_datum.push_back(control.point);
  }
  record.sigma_factors = factors_by_word(orientation.sigma_factors);
  record.position_shift_m = orientation.position_shift_m;
  record.instruments = orientation.instruments;
  record.calibration = orientation.calibration.parameters;
  record.not_oriented = orientation.alone;
  record.other_parts = orientation.other_parts;
  record.excluded_control.assign(orientation.excluded_control.begin(), orientation.excluded_control.end());
  record.excluded_geodetic.assign(orientation.excluded_geodetic.begin(), orientation.excluded_geodetic.end());
  record.excluded_positions = orientation.excluded_positions;
  record.findings = orientation.findings;
  return record;
}

}  // namespace collinea
