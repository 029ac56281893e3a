// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_control.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/adjust/geodetic_model.h"
#include "collinea/block/gnss_vector.h"
#include "collinea/block/survey_covariance.h"
#include "collinea/import/image_names.h"
#include "collinea/io/geodetic_file.h"

namespace collinea {
namespace {

// Points surveyed in another CRS than the map's come by way of geographic coordinates.
Result<Eigen::Vector3d> in_world(const ControlFilePoint& point, const std::string& crs, const LocalFrame& frame) {
  if (crs.empty() || crs == frame.crs()) return frame.local_from_map(point.position_in_map);
  return geographic_from_map(crs, point.position_in_map)
      .map([&](const Eigen::Vector3d& geographic) { return frame.local_from_geographic(geographic); })
      .map_error([&](Error error) { return std::move(error).within("control " + point.name); });
}

// A covariance along the axes of the point's map, as one along those of the world. The axes differ by the convergence
// of meridians and by the scale of the map, which the survey was reduced by.
Result<> rotate_covariance(const ControlFilePoint& point, const std::string& crs, const LocalFrame& frame,
                           ControlPoint& taken) {
  Eigen::Matrix3d world_from_map;
  for (int axis = 0; axis < 3; ++axis) {
    ControlFilePoint shifted = point;
    shifted.position_in_map[axis] += 1;
    COLLINEA_TRY(const Eigen::Vector3d there, in_world(shifted, crs, frame));
    world_from_map.col(axis) = (there - taken.position_in_world).normalized();
  }
  const Eigen::Matrix3d covariance =
      world_from_map * survey_covariance(point.sigma_m, point.correlation) * world_from_map.transpose();
  for (int axis = 0; axis < 3; ++axis)
    if (std::isfinite(point.sigma_m[axis])) taken.sigma_m[axis] = std::sqrt(covariance(axis, axis));
  taken.correlation = correlation_of(covariance);
  return {};
}

// What was measured in a scan of film, in the ideal image that it becomes.
Eigen::Vector2d in_ideal_image(const Imported& imported, ImageId image, const Eigen::Vector2d& pixel) {
  if (!imported.film) return pixel;
  const auto film_mm = imported.film->scans.at(image).scan_from_film().film_of(pixel);
  return film_mm ? imported.film->ideal.pixel_of(*film_mm) : Eigen::Vector2d(-1, -1);
}

constexpr std::size_t kFewOutside = 4, kPartOutside = 3;

// Marks outside their images are slips when they are few. When they are a third of all, the marks were counted in
// another way than from the upper-left corner of these images, and orientation finds out in which: all are kept.
bool are_counted_otherwise(const std::vector<ControlObservation>& outside, std::size_t all) {
  return outside.size() >= kFewOutside && kPartOutside * outside.size() >= all;
}

bool is_surveyed(const ControlFilePoint& point) { return point.sigma_m.array().isFinite().any(); }

}  // namespace

bool is_surveyed(const ControlFile& control) {
  return std::any_of(control.points.begin(), control.points.end(),
                     [](const auto& point) { return is_surveyed(point); });
}

Result<> add_control(Imported& imported, const ControlFile& control, const LocalFrame* frame) {
  Block& block = imported.block;
  std::map<std::string, ControlId> by_name;
  for (const ControlFilePoint& point : control.points) {
    const ControlId id{static_cast<std::uint32_t>(block.control.size())};
    by_name[point.name] = id;
    Eigen::Vector3d world = Eigen::Vector3d::Zero();  // of a point without any coordinate nothing is known
    if (is_surveyed(point)) {
      COLLINEA_TRY(world, in_world(point, control.crs, *frame));
    }
    const Eigen::Vector3d in_map = frame ? frame->map_from_local(world) : world;
    ControlPoint& taken = block.control[id] = {point.name, point.role, in_map, world, point.sigma_m};
    if (!point.correlation.isZero(0))
      if (Result<> rotated = rotate_covariance(point, control.crs, *frame, taken); !rotated) return rotated;
  }
  const ImageNames images(block);
  std::map<std::string, int> missing;
  std::vector<Finding> each_outside;
  std::vector<ControlObservation> outside;
  for (const ControlFileObservation& row : control.observations) {
    const auto image = images.find(row.file);
    if (!image) {
      ++missing[row.file];
      continue;
    }
    const ControlId point = by_name.at(row.point);
    const Eigen::Vector2d pixel = in_ideal_image(imported, *image, row.pixel);
    const bool is_inside = inside(block.camera_of(*image), pixel);
    (is_inside ? block.control_observations : outside).push_back({point, *image, pixel, row.sigma_px, row.shape});
    if (!is_inside)
      each_outside.push_back(finding_of(FindingCode::kControlOutsideImage, {point, *image},
                                        {{FigureName::kPixelX, row.pixel.x()},
                                         {FigureName::kPixelY, row.pixel.y()},
                                         {FigureName::kLine, double(row.line)}}));
  }
  if (const std::size_t all = outside.size() + block.control_observations.size();
      frame && are_counted_otherwise(outside, all)) {
    block.control_observations.insert(block.control_observations.end(), outside.begin(), outside.end());
    each_outside = {finding_of(FindingCode::kMarksOutside, {},
                               {{FigureName::kCount, double(outside.size())}, {FigureName::kOf, double(all)}},
                               {RemedyCode::kCorrectMarks})};
  }
  imported.findings.insert(imported.findings.end(), each_outside.begin(), each_outside.end());
  for (const auto& [file, rows] : missing)
    imported.findings.push_back(
        finding_of(FindingCode::kControlImageMissing, {Subject::file(file)}, {{FigureName::kCount, double(rows)}}));
  return {};
}

namespace {

// A shape that any points of that number lie on says nothing.
Result<> check_shapes(const Block& block, const std::filesystem::path& file) {
  std::map<std::pair<GeodeticKind, std::uint32_t>, std::pair<std::string, std::set<ControlId>>> shapes;
  for (const GeodeticObservation& one : block.geodetic) {
    if (!one.is_of_shape()) continue;
    auto& [name, points] = shapes[{one.kind, one.setup}];
    name = one.name;
    points.insert(one.from);
  }
  for (const auto& [key, shape] : shapes) {
    const auto& [name, points] = shape;
    const auto least = static_cast<std::size_t>(points_of_shape(key.first)) + 1;
    if (points.size() < least)
      return fail(Errc::kBadInput, fmt::format("{}: {} {} has {} point{}, which says nothing: name at least {}",
                                               file.string(), kGeodeticKindNames[static_cast<std::size_t>(key.first)],
                                               name, points.size(), points.size() == 1 ? "" : "s", least));
  }
  return {};
}

/// Shapes of one kind by their names.
class ShapeNumbers {
 public:
  std::uint32_t number_of(GeodeticKind kind, const std::string& name) {
    auto& numbers = numbers_[kind];
    return numbers.try_emplace(name, static_cast<std::uint32_t>(numbers.size())).first->second;
  }

 private:
  std::map<GeodeticKind, std::map<std::string, std::uint32_t>> numbers_;
};

}  // namespace

Result<> add_geodetic(Imported& imported, const std::filesystem::path& file) {
  Block& block = imported.block;
  COLLINEA_TRY(const std::vector<GeodeticFileRow> rows, read_geodetic(file));
  std::map<std::string, ControlId> by_name;
  for (const auto& [id, point] : block.control) by_name[point.name] = id;
  std::map<std::string, std::pair<std::uint32_t, ControlId>> setups;
  ShapeNumbers shapes;
  std::uint32_t vectors = 0;
  for (const GeodeticFileRow& row : rows) {
    const auto bad = [&](const std::string& what) {
      return fail(Errc::kBadInput, fmt::format("{}: line {}: {}", file.string(), row.line, what));
    };
    GeodeticObservation one{
        .kind = row.kind, .name = row.name, .value = row.value, .sigma = row.sigma, .role = row.role};
    one.instrument_height_m = row.instrument_height_m;
    one.target_height_m = row.target_height_m;
    for (const auto& [name, id] : {std::pair(&row.from, &one.from), std::pair(&row.to, &one.to)}) {
      const auto known = by_name.find(*name);
      if (known == by_name.end())
        return bad(block.control.empty()
                       ? "there is no point " + *name + ": points and where images show them come from a control file"
                       : "there is no point " + *name + " in the control file");
      *id = known->second;
    }
    if (row.kind == GeodeticKind::kDirection) {
      const auto [its, is_new] = setups.try_emplace(row.setup.empty() ? "on " + row.from : row.setup,
                                                    static_cast<std::uint32_t>(setups.size()), one.from);
      if (its->second.second != one.from)
        return bad("set-up " + row.setup + " stands on " + block.control.at(its->second.second).name + " and on " +
                   row.from);
      one.setup = its->second.first;
    }
    if (row.kind == GeodeticKind::kGnssVector) {
      GnssVector vector = row.vector;
      if (row.is_geocentric) {
        if (!block.georeference)
          return bad("a geocentric vector needs a block with a location on Earth: control in a map, or positions");
        const Eigen::Matrix3d rotation = world_from_geocentric(*block.georeference);
        vector.vector = rotation * vector.vector;
        vector.covariance_m2 = rotation * vector.covariance_m2 * rotation.transpose();
      }
      one.setup = vectors++;
      const auto parts = observations_of(vector, one);
      if (!parts) return bad("the covariance is none: it has to be positive definite");
      block.geodetic.insert(block.geodetic.end(), parts->begin(), parts->end());
      continue;
    }
    if (one.is_of_shape()) {
      one.setup = shapes.number_of(row.kind, row.name);
      one.axis = row.axis;
    }
    block.geodetic.push_back(std::move(one));
  }
  return check_shapes(block, file);
}

}  // namespace collinea
