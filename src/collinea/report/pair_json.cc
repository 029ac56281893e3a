// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "collinea/report/internal/finding_json.h"
#include "collinea/report/json_values.h"
#include "collinea/report/pair_report.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;

json rows(const Eigen::MatrixXd& matrix) {
  json list = json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    json row = json::array();
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) row.push_back(number(matrix(i, k)));
    list.push_back(std::move(row));
  }
  return list;
}

json estimate_json(const Estimate& one) {
  return {{"name", one.name},
          {"value", number(one.value)},
          {"sigma", one.sigma ? number(*one.sigma) : json(nullptr)},
          {"unit", one.unit}};
}

json estimates_json(std::span<const Estimate> estimates) {
  json list = json::array();
  for (const Estimate& one : estimates) list.push_back(estimate_json(one));
  return list;
}

json search_json(const PairReport& report) {
  json list = json::array();
  for (const PairPointStage& stage : report.search)
    list.push_back({{"shrink", stage.shrink},
                    {"interest", stage.interest},
                    {"matched", stage.matched},
                    {"agreeing", stage.agreeing},
                    {"parallax_px", {number(stage.parallax_px.x()), number(stage.parallax_px.y())}}});
  return list;
}

json orientation_json(const PairOrientation& of) {
  const RelativeOrientation& found = of.orientation;
  json one = {{"by", of.by},
              {"shrink", of.shrink},
              {"points", of.points},
              {"rejected", of.rejected},
              {"sigma0_px", number(of.sigma0_px)},
              {"redundancy", number(found.redundancy)},
              {"in_front", found.in_front}};
  const Eigen::Quaterniond& q = found.second_from_first.rotation;
  one["right_from_left"] = {{"quaternion_wxyz", {q.w(), q.x(), q.y(), q.z()}},
                            {"translation_bases", vector(found.second_from_first.translation)}};
  if (const auto d = dependent_elements(found.second_from_first)) {
    const Matrix5 by = dependent_by_change(found.second_from_first);
    one["dependent"] = {{"elements", {"by", "bz", "omega_rad", "phi_rad", "kappa_rad"}},
                        {"bx", d->bx},
                        {"values", rows(d->values().transpose())[0]},
                        {"covariance", rows(by * found.stated_covariance() * by.transpose())}};
  }
  const Matrix5 by = symmetric_by_change(found.second_from_first);
  one["symmetric"] = {{"elements", {"phi1_rad", "kappa1_rad", "omega2_rad", "phi2_rad", "kappa2_rad"}},
                      {"values", rows(symmetric_elements(found.second_from_first).values().transpose())[0]},
                      {"covariance", rows(by * found.stated_covariance() * by.transpose())}};
  return one;
}

json shape_json(const PairShape& shape) {
  json one = {{"points", shape.points},
              {"distance_bases", number(shape.distance)},
              {"width_bases", number(shape.width)},
              {"breadth_rad", number(shape.breadth)},
              {"median_angle_rad", number(shape.median_angle_rad)},
              {"plane_roughness_bases", number(shape.plane_roughness)},
              {"epsilon", number(shape.epsilon)},
              {"null_vector", rows(shape.null_vector.transpose())[0]},
              {"inflation", number(shape.inflation)},
              {"cylinder", nullptr},
              {"weaknesses", json::array()}};
  if (shape.cylinder)
    one["cylinder"] = {{"radius_bases", number(shape.cylinder->radius)},
                       {"roughness_bases", number(shape.cylinder->roughness)}};
  for (const PairWeakness weakness : shape.weaknesses) one["weaknesses"].push_back(word_of(weakness));
  return one;
}

json absolute_json(const AbsoluteReport& report) {
  json one = {{"parameters", estimates_json(report.parameters)},
              {"covariance", rows(report.covariance)},  // m, rad
              {"sigma0", number(report.variance.sigma0)},
              {"redundancy", report.variance.redundancy},
              {"points", json::array()}};
  for (const AbsoluteReport::Point& point : report.points)
    one["points"].push_back({{"name", point.name},
                             {"role", point.is_check      ? "check"
                                      : point.is_rejected ? "rejected"
                                                          : "control"},
                             {"misfit_m", vector(point.misfit)},
                             {"sigma_m", vector(point.sigma)},
                             {"redundancy", vector(point.redundancy)},
                             {"w", vector(point.w)}});
  return one;
}

json surface_json(const PairReport& report) {
  json one = {{"kind", word_of(report.surface)},
              {"points", report.surface_points},
              {"median_sigma_px", number(report.median_sigma_px)},
              {report.has_base ? "median_sigma_depth_m" : "median_sigma_depth_bases", number(report.median_sigma_z)},
              {"levels", json::array()}};
  for (const LevelCount& level : report.levels)
    one["levels"].push_back({{"shrink", level.shrink},
                             {"threshold", number(level.threshold)},
                             {"interest", level.interest},
                             {"matched", level.matched},
                             {"grown", level.grown},
                             {"spikes", level.spikes},
                             {"is_dropped", level.is_dropped}});
  return one;
}

json map_json(const PairMap& map) {
  return {{"cell_m", number(map.cell_m)},
          {"width", map.width},
          {"height", map.height},
          {"measured_cells", map.measured_cells},
          {"interpolated_cells", map.interpolated_cells},
          {"painted_cells", map.painted_cells},
          {"mean_sigma_m", number(map.mean_sigma_m)},
          {"mean_sigma_relative_m", number(map.mean_sigma_relative_m)}};
}

json epipolar_json(const PairReport& report) {
  const Camera &left = report.epipolar.left, &right = report.epipolar.right;
  return {{"left_px", {left.width_px, left.height_px}},
          {"right_px", {right.width_px, right.height_px}},
          {"principal_distance_px", number(left.focal_px())},
          {"left_principal_point_px", {left.params[Camera::kCx], left.params[Camera::kCy]}},
          {"right_principal_point_px", {right.params[Camera::kCx], right.params[Camera::kCy]}},
          {"resampling", word_of(report.resampling)},
          {"y_parallax_rms_px", number(report.y_parallax_rms_px)},
          {"row_sigma_px", number(report.row_sigma_px)}};
}

}  // namespace

std::string pair_json(const PairReport& report) {
  json all = {{"images", json::array()}, {"shrink", report.shrink}};
  for (std::size_t i = 0; i < 2; ++i)
    all["images"].push_back({{"file", report.files[i].filename().string()},
                             {"width_px", report.cameras[i].width_px},
                             {"height_px", report.cameras[i].height_px},
                             {"principal_distance_px", number(report.cameras[i].focal_px())},
                             {"exterior", estimates_json(report.exterior[i].elements)}});
  all["is_given"] = report.is_given;
  all["exterior_frame"] = report.absolute ? "ground" : "model";
  for (const PairScan& scan : report.scans)
    all["scans"].push_back({{"marks", scan.marks},
                            {"misread", scan.misread},
                            {"rms_um", number(scan.rms_um)},
                            {"pixel_um", number(scan.pixel_um)}});
  all["search"] = search_json(report);
  all["relative"] = json::array();
  for (const PairOrientation& of : report.orientations) all["relative"].push_back(orientation_json(of));
  all["geometry"] = report.relative && report.relative->shape ? shape_json(*report.relative->shape) : json(nullptr);
  all["epipolar"] = epipolar_json(report);
  all["surface"] = surface_json(report);
  all["absolute"] = report.control ? absolute_json(*report.control) : json(nullptr);
  all["map"] = report.map ? map_json(*report.map) : json(nullptr);
  all["findings"] = findings_json(report.findings, Block{});
  return all.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace collinea
