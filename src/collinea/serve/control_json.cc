// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/control_json.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/geodesy/proj_text.h"
#include "collinea/jobs/marking_project.h"
#include "collinea/marking/image_footprint.h"
#include "collinea/raster/image_tiles.h"
#include "collinea/report/json_values.h"

namespace collinea {
namespace {

using json = nlohmann::ordered_json;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

std::string text_of(const json& value) { return value.dump(-1, ' ', false, json::error_handler_t::replace); }

// Numbers with so many digits behind the point: a tenth of what is measured, and a third of the bytes.
json rounded(double value, int digits) {
  const double scale = std::pow(10.0, digits);
  return number(std::round(value * scale) / scale);
}
json rounded(const Vector3d& v, int digits) {
  return {rounded(v.x(), digits), rounded(v.y(), digits), rounded(v.z(), digits)};
}
json rounded(const Vector2d& v, int digits) { return {rounded(v.x(), digits), rounded(v.y(), digits)}; }

std::optional<Vector3d> position_of(const ProjectView& view, ImageId id) {
  if (const auto pose = find_pose(view.block, id)) return centre_of(*pose);
  const auto& position = view.block.images.at(id).position;
  return position && view.frame ? std::optional(position->position_in_world) : std::nullopt;
}

json footprint_of(const ProjectView& view, const TiedBlock& ties, ImageId id) {
  const auto pose = find_pose(view.block, id);
  const auto height = ties.ground_height.find(id);
  if (!pose || height == ties.ground_height.end()) return nullptr;
  const auto outline = image_footprint(view.block.camera_of(id), *pose, height->second);
  if (!outline) return nullptr;
  json all = json::array();
  for (const Vector3d& p : *outline) all.push_back(rounded(Vector2d(view.in_map(p).head<2>()), 3));
  return all;
}

// In the map's axes, from the projection centre.
json corner_rays_of(const ProjectView& view, ImageId id) {
  const auto pose = find_pose(view.block, id);
  const auto rays = pose ? corner_rays(view.block.camera_of(id), *pose) : std::nullopt;
  if (!rays) return nullptr;
  const Vector3d centre = centre_of(*pose);
  json all = json::array();
  for (const Vector3d& ray : *rays)
    all.push_back(rounded(Vector3d(view.in_map(centre + ray) - view.in_map(centre)), 6));
  return all;
}

struct Bounds {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity());
  Vector2d high = -low;
  void add(const Vector3d& p) {
    if (!p.allFinite()) return;
    low = low.cwiseMin(p.head<2>());
    high = high.cwiseMax(p.head<2>());
  }
};

}  // namespace

Result<std::string> map_json(const ProjectView& view) {
  Bounds bounds;
  for (const auto& [id, image] : view.block.images)
    if (const auto position = position_of(view, id)) bounds.add(view.in_map(*position));
  for (const auto& [id, point] : view.control)
    if (view.frame) bounds.add(point.position_in_map);
  if (count_oriented(view.block) > 0) {
    COLLINEA_TRY(const auto ties, view.ties());
    for (const OrientedImage& one : oriented_images(view.block)) {
      const auto height = ties->ground_height.find(one.image);
      if (height == ties->ground_height.end()) continue;
      if (const auto outline = image_footprint(view.block.camera_of(one.image), one.cam_from_world, height->second))
        for (const Vector3d& p : *outline) bounds.add(view.in_map(p));
    }
  }
  json all = {{"crs", nullptr}, {"crs_name", nullptr}, {"proj4", nullptr}, {"unit", "m"}, {"bounds", nullptr}};
  if (view.frame) {
    all["crs"] = view.frame->crs();
    all["crs_name"] = view.frame->crs_name();
    if (const auto text = proj_text(*view.frame)) all["proj4"] = *text;
  } else if (!view.orientation || !view.orientation->metric) {
    all["unit"] = nullptr;  // a unit of the block's own
  }
  if (bounds.low.allFinite())
    all["bounds"] = {rounded(bounds.low.x(), 3), rounded(bounds.low.y(), 3), rounded(bounds.high.x(), 3),
                     rounded(bounds.high.y(), 3)};
  return text_of(all);
}

Result<std::string> images_json(const ProjectView& view) {
  std::map<ImageId, int> marks;
  for (const ControlObservation& mark : view.marks) ++marks[mark.image];
  std::shared_ptr<const TiedBlock> ties = std::make_shared<TiedBlock>();
  if (count_oriented(view.block) > 0) {
    COLLINEA_TRY(ties, view.ties());
  }
  json all = {{"tile_px", kTilePx}, {"images", json::array()}};
  for (const auto& [id, image] : view.block.images) {
    const Camera& camera = view.block.camera_of(id);
    const auto position = position_of(view, id);
    json sigma = nullptr;
    if (view.adjustment)
      if (const auto found = view.adjustment->centre_sigma_m.find(id); found != view.adjustment->centre_sigma_m.end())
        sigma = rounded(found->second, 5);
    if (!is_oriented(view.block, id) && image.position) sigma = rounded(image.position->sigma_m, 5);
    all["images"].push_back({{"id", id.value},
                             {"file", image.file},
                             {"width", camera.width_px},
                             {"height", camera.height_px},
                             {"levels", tile_levels(camera.width_px, camera.height_px)},
                             {"camera", image.camera.value},
                             {"oriented", is_oriented(view.block, id)},
                             {"position", position ? rounded(view.in_map(*position), 4) : json(nullptr)},
                             {"sigma_m", sigma},
                             {"footprint", footprint_of(view, *ties, id)},
                             {"corner_rays", corner_rays_of(view, id)},
                             {"marks", marks[id]}});
  }
  return text_of(all);
}

Result<std::string> residuals_json(const ProjectView& view, ImageId image) {
  json points = json::array();
  const auto pose = find_pose(view.block, image);
  if (pose) {
    COLLINEA_TRY(const auto ties, view.ties());
    const auto found = ties->observations.find(image);
    const std::size_t count = found == ties->observations.end() ? 0 : found->second.size();
    const std::size_t taken = std::min(count, kMostResiduals);
    for (std::size_t i = 0; i < taken; ++i) {
      const Observation& seen = ties->block.observations[found->second[i * count / taken]];
      const auto computed =
          project(view.block.camera_of(image), *pose * ties->block.points.at(seen.point).position_in_world);
      if (!computed) continue;
      const Vector2d residual = seen.pixel - *computed;
      points.push_back(
          {rounded(seen.pixel.x(), 2), rounded(seen.pixel.y(), 2), rounded(residual.x(), 3), rounded(residual.y(), 3)});
    }
  }
  return text_of({{"points", points}});
}

Result<std::string> ties_json(const ProjectView& view, std::size_t most) {
  COLLINEA_TRY(const auto ties, view.ties());
  const std::size_t count = ties->block.points.size(), taken = std::min({count, most, kMostTies});
  const double scale = sigma_scale(view.adjustment);
  json points = json::array();
  std::size_t index = 0, next = 0;
  for (const auto& [id, point] : ties->block.points) {
    const std::size_t at = index++;
    if (next >= taken || at != next * count / taken) continue;
    ++next;
    json one = rounded(view.in_map(point.position_in_world), 4);
    if (at < ties->covariances.points.size()) {
      const Matrix3d turned = view.map_from_world() * ties->covariances.points[at] * view.map_from_world().transpose();
      const Matrix3d covariance = scale * scale * turned;
      for (int k = 0; k < 3; ++k) one.push_back(rounded(std::sqrt(covariance(k, k)), 5));
      one.push_back(number(covariance(0, 1)));
    } else {
      for (int k = 0; k < 4; ++k) one.push_back(nullptr);
    }
    points.push_back(std::move(one));
  }
  return text_of({{"points", points}});
}

namespace {

const ControlDifference* difference_of(const ProjectView& view, ControlId id) {
  if (view.adjustment)
    for (const ControlDifference& one : view.adjustment->control)
      if (one.point == id) return &one;
  return nullptr;
}

// Of the two coordinates; NaN counts as not known.
double larger(const Vector2d& v) { return std::fmax(v.x(), v.y()); }

json mark_json(const ProjectView& view, const ControlObservation& mark, const std::optional<MarkTests>& tests) {
  json one = {{"image", mark.image.value},       {"file", view.block.images.at(mark.image).file},
              {"pixel", rounded(mark.pixel, 3)}, {"sigma_px", number(mark.sigma_px)},
              {"residual_px", nullptr},          {"w", nullptr},
              {"redundancy", nullptr},           {"detectable_px", nullptr}};
  if (!tests) return one;
  one["residual_px"] = rounded(tests->residual_px, 4);
  one["w"] =
      number(std::abs(tests->w.x()) > std::abs(tests->w.y()) || std::isnan(tests->w.y()) ? tests->w.x() : tests->w.y());
  one["redundancy"] = number(std::fmin(tests->redundancy.x(), tests->redundancy.y()));
  one["detectable_px"] = number(larger(tests->detectable_px));
  return one;
}

json given_json(const ProjectView& view, const ControlPoint& point) {
  return {{"name", point.name},
          {"role", point.role == ControlRole::kControl ? "control" : "check"},
          {"position", rounded(view.frame ? point.position_in_map : point.position_in_world, 5)},
          {"sigma_m", vector(point.sigma_m)},
          {"adjusted", nullptr},
          {"difference_m", nullptr},
          {"difference_sigma_m", nullptr},
          {"marks", json::array()}};
}

json point_json(const ProjectView& view, ControlId id, const ControlPoint& point) {
  json one = given_json(view, point);
  // A point of the same number may have been renamed or given anew since the adjustment.
  const auto adjusted = view.block.control.find(id);
  const ControlDifference* difference =
      adjusted != view.block.control.end() && adjusted->second.name == point.name ? difference_of(view, id) : nullptr;
  if (difference && difference->position_in_world) {
    one["adjusted"] = rounded(view.in_map(*difference->position_in_world), 5);
    const Matrix3d turn = view.map_from_world();
    if (difference->difference_m.allFinite())
      one["difference_m"] = rounded(Vector3d(turn * difference->difference_m), 5);
    if (difference->difference_sigma_m.allFinite())
      one["difference_sigma_m"] = rounded(difference->difference_sigma_m, 5);
  }
  return one;
}

}  // namespace

std::string control_json(const ProjectView& view) {
  json all = {{"points", json::array()}, {"sigma0", view.adjustment ? number(view.adjustment->sigma0) : json(nullptr)}};
  std::map<ControlId, json> marks;
  for (const ControlObservation& mark : view.marks)
    if (view.block.images.contains(mark.image)) marks[mark.point].push_back(mark_json(view, mark, view.tests_of(mark)));
  for (const auto& [id, point] : view.control) {
    json one = point_json(view, id, point);
    if (const auto found = marks.find(id); found != marks.end()) one["marks"] = std::move(found->second);
    all["points"].push_back(std::move(one));
  }
  return text_of(all);
}

namespace {

json point_now_json(const ProjectView& view, const ControlPoint& point, const AdjustedMark& adjusted, bool placed) {
  json one = given_json(view, point);
  if (!adjusted.position_in_world) return one;
  one["adjusted"] = rounded(view.in_map(*adjusted.position_in_world), 5);
  if (placed && adjusted.difference_m.allFinite())
    one["difference_m"] = rounded(Vector3d(view.map_from_world() * adjusted.difference_m), 5);
  if (placed && adjusted.difference_sigma_m.allFinite())
    one["difference_sigma_m"] = rounded(adjusted.difference_sigma_m, 5);
  return one;
}

std::optional<MarkTests> tests_in(const BlockMarkTest& test) {
  if (!test.residual_px.allFinite()) return std::nullopt;
  return MarkTests{test.residual_px, test.w, test.redundancy, test.minimal_detectable_bias_px};
}

}  // namespace

Result<std::string> control_now_json(const ProjectView& view) {
  COLLINEA_TRY(const AdjustedMarks now, view.adjusted_with_marks());
  json all = {{"points", json::array()}, {"sigma0", number(now.sigma0)}};
  std::map<ControlId, std::size_t> index_of;  // in the order of the control
  for (const auto& [id, point] : view.control) {
    const AdjustedMark& adjusted = now.points[index_of.size()];
    index_of.emplace(id, index_of.size());
    all["points"].push_back(point_now_json(view, point, adjusted, now.placed));
  }
  std::map<ControlId, std::size_t> next;
  for (const ControlObservation& mark : view.marks) {
    const auto at = index_of.find(mark.point);
    if (at == index_of.end()) continue;
    const auto& tests = now.points[at->second].marks;
    const std::size_t i = next[mark.point]++;
    if (view.block.images.contains(mark.image) && i < tests.size())
      all["points"][at->second]["marks"].push_back(mark_json(view, mark, tests_in(tests[i])));
  }
  return text_of(all);
}

}  // namespace collinea
