// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/orient.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "collinea/base/hash.h"
#include "collinea/epipolar/intersect.h"
#include "collinea/project/given_orientation.h"
#include "collinea/project/json_text.h"
#include "collinea/raster/photo.h"
#include "collinea/report/statistics.h"
#include "collinea/steps/step.h"

namespace collinea {
namespace {

using nlohmann::json;

const Eigen::Vector3d kUnknown = Eigen::Vector3d::Constant(std::nan(""));

// Root mean square per axis; null where nothing was measured on it.
json axes_of(const AxisRms& rms) {
  json axes = json::array();
  for (const auto& axis : rms.axis_m) axes.push_back(axis ? json(*axis) : json(nullptr));
  return rms.points ? axes : json(nullptr);
}

// Without the axes that were not measured.
Eigen::Vector3d measured_axes(Eigen::Vector3d difference, const Eigen::Vector3d& sigma_m) {
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isfinite(sigma_m[axis])) difference[axis] = std::nan("");
  return difference;
}

json control_rms(const Orientation& orientation, bool used) {
  std::vector<Eigen::Vector3d> differences;
  for (const ControlDifference& control : orientation.adjusted.control)
    if (control.used == used && control.position_in_world && !orientation.excluded_control.contains(control.point))
      differences.push_back(control.difference_m);
  return axes_of(rms_of(differences));
}

Eigen::Vector3d measured_axes(const PositionDifference& position, const Block& block) {
  return measured_axes(position.difference_m, block.images.at(position.image).position->sigma_m);
}

json position_rms(const Orientation& orientation) {
  std::vector<Eigen::Vector3d> differences;
  for (const PositionDifference& position : orientation.adjusted.positions)
    differences.push_back(measured_axes(position, orientation.block));
  return axes_of(rms_of(differences));
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

json files_of(const Block& block, const std::vector<ImageId>& images) {
  json files = json::array();
  for (const ImageId image : images) files.push_back(block.images.at(image).file);
  return files;
}

json numbers(const auto& values) {
  json list = json::array();
  for (const double value : values) list.push_back(std::isfinite(value) ? json(value) : json(nullptr));
  return list;
}

json options_json(const auto& options) {
  json object;
  std::decay_t<decltype(options)>::describe([&](const auto& field) {
    const auto& value = options.*field.member;
    json& own = object[std::string(field.name)];
    if constexpr (requires { value.has_value(); }) {
      if (value) own = *value;
    } else if constexpr (Worded<std::decay_t<decltype(value)>>) {
      own = word_of(value);
    } else {
      own = value;
    }
  });
  return object;
}

// Control that was found wrong took no part: what it is off by, seen with its measurements as they were given.
json excluded_control(const Orientation& orientation, const Block& setup) {
  Block measured;
  measured.cameras = orientation.block.cameras;
  measured.images = setup.images;
  measured.cam_from_world = orientation.block.cam_from_world;
  measured.control_observations = setup.control_observations;
  json rows = json::array();
  for (const ControlId id : orientation.excluded_control) {
    const ControlPoint& point = orientation.block.control.at(id);
    const std::vector<SightLine> lines = sight_lines(measured, id);
    Eigen::Vector3d off_m = kUnknown;
    if (const auto met = intersect(lines))
      off_m = measured_axes(met->point_in_world - point.position_in_world, point.sigma_m);
    rows.push_back({{"point", id.value},
                    {"used", false},
                    {"excluded", true},
                    {"rays", lines.size()},
                    {"difference_m", numbers(off_m)},
                    {"sigma_m", numbers(kUnknown)}});
  }
  return rows;
}

// What only the report needs: differences and sigmas one by one.
json details_of(const Orientation& orientation, const Block& setup) {
  const Adjusted& adjusted = orientation.adjusted;
  json details = {{"control", json::array()},         {"positions", json::array()},    {"ground", json::array()},
                  {"places", json::array()},  // east, north in the world, standard deviation of the height
                  {"centre_sigma_m", json::object()}, {"camera_sigma", json::object()}};
  for (const ControlDifference& control : adjusted.control)
    details["control"].push_back({{"point", control.point.value},
                                  {"used", control.used},
                                  {"excluded", false},
                                  {"rays", control.rays},
                                  {"difference_m", numbers(control.difference_m)},
                                  {"sigma_m", numbers(control.difference_sigma_m)}});
  for (json& row : excluded_control(orientation, setup)) details["control"].push_back(std::move(row));
  for (const PositionDifference& position : adjusted.positions)
    details["positions"].push_back({{"image", position.image.value},
                                    {"difference_m", numbers(measured_axes(position, orientation.block))},
                                    {"weight", position.weight}});
  for (const GroundDifference& ground : adjusted.ground)
    details["ground"].push_back({{"observation", ground.observation},
                                 {"used", ground.used},
                                 {"excluded", orientation.excluded_ground.contains(ground.observation)},
                                 {"adjusted", ground.adjusted},
                                 {"difference", ground.difference},
                                 {"sigma", numbers(std::array{ground.difference_sigma})[0]}});
  for (const PlacePrecision& place : adjusted.places)
    details["places"].push_back(
        numbers(Eigen::Vector3d(place.position_in_world.x(), place.position_in_world.y(),
                                std::sqrt(std::max(0.0, place.covariance_m2(2, 2))) * sigma_scale(adjusted))));
  for (const auto& [image, covariance] : adjusted.pose_covariance)
    details["centre_sigma_m"][std::to_string(image.value)] =
        numbers(Eigen::Vector3d(covariance.diagonal().tail<3>().cwiseSqrt() * sigma_scale(adjusted)));
  for (const auto& [camera, covariance] : adjusted.camera_covariance)
    details["camera_sigma"][std::to_string(camera.value)] =
        numbers(Eigen::VectorXd(covariance.diagonal().cwiseSqrt() * sigma_scale(adjusted)));
  return details;
}

json report_of(const Orientation& orientation, const Block& setup) {
  const Adjusted& adjusted = orientation.adjusted;
  json report = {{"images", setup.images.size()},
                 {"oriented", orientation.block.cam_from_world.size()},
                 {"tie_points", orientation.block.points.size()},
                 {"observations", orientation.block.observations.size()},
                 {"gross_measurements", orientation.gross_measurements},
                 {"mean_reprojection_px", mean_residual_px(adjusted)},
                 {"gsd_m", orientation.metric ? json(orientation.gsd_m) : json(nullptr)},
                 {"pixel_in_units", orientation.gsd_m},
                 {"sigma0", adjusted.sigma0},
                 {"redundancy", adjusted.redundancy},
                 {"georeferenced", orientation.georeferenced},
                 {"metric", orientation.metric},
                 {"gauge", orientation.gauge},
                 {"relative_heights", orientation.relative_heights},
                 {"control_rmse_m", control_rms(orientation, true)},
                 {"check_rmse_m", control_rms(orientation, false)},
                 {"position_rms_m", position_rms(orientation)},
                 {"sigma_factors", numbers(orientation.sigma_factors)},
                 {"position_shift_m", numbers(orientation.position_shift_m)},
                 {"instruments", options_json(orientation.instruments)},
                 {"not_oriented", files_of(orientation.block, orientation.alone)},
                 {"findings", orientation.findings}};
  report["other_parts"] = json::array();
  for (const auto& part : orientation.other_parts) report["other_parts"].push_back(files_of(orientation.block, part));
  report["details"] = details_of(orientation, setup);
  return report;
}

// By our own means, or from another program's.
Result<Orientation> orientation_of(Project& project, const Block& setup, const std::vector<ImagePair>& pairs) {
  const auto keypoints = [&](ImageId image) { return project.store.read_keypoints(image); };
  const OrientOptions& options = project.settings.orient;
  const auto pictures = [&](ImageId image) { return read_grey(project.photo(setup.images.at(image))); };
  if (!options.orientation) return orient(setup, pairs, keypoints, options, project.run, pictures);
  COLLINEA_TRY(const ReadOrientation read, read_orientation(*options.orientation, setup));
  COLLINEA_TRY(Orientation orientation,
               orient_as_given(setup, pairs, keypoints, read.given, options, project.run, pictures));
  orientation.findings.insert(orientation.findings.begin(), read.remarks.begin(), read.remarks.end());
  orientation.findings.insert(orientation.findings.begin(),
                              fmt::format("{} of the {} images is taken from {}{}",
                                          read.given.cameras.empty() ? "orientation" : "orientation and camera",
                                          read.given.cam_from_world.size(), read.given.source,
                                          options.refine_orientation ? ", and adjusted" : ", and held as given"));
  return orientation;
}

}  // namespace

Result<StepOutput> orient_step(Project& project, const std::string& inputs_hash) {
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  COLLINEA_TRY(const std::vector<ImagePair> pairs, project.store.read_pairs());
  COLLINEA_TRY(Orientation orientation, orientation_of(project, setup, pairs));
  COLLINEA_TRY(project.store.write_orientation(orientation.block));
  for (const std::string& finding : orientation.findings) project.run.say("note: " + finding);
  const json report = report_of(orientation, setup);
  return StepOutput{
      inputs_hash, json_text(report),
      fmt::format("{} of {} images, {} tie points, mean residual {:.2f} px, {}",
                  orientation.block.cam_from_world.size(), setup.images.size(), orientation.block.points.size(),
                  mean_residual_px(orientation.adjusted), orientation.gauge)};
}

}  // namespace collinea
