// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_location.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/geodesy/heights.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/import/internal/import_control.h"

namespace collinea {
namespace {

// The middle of the block: where the world frame gets its origin, rounded so that it reads well.
Eigen::Vector3d middle_of(const Block& block) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0, heights = 0;
  double first_longitude_deg = 0;
  for (const auto& [id, image] : block.images)
    if (const auto& position = image.position) {
      if (count++ == 0) first_longitude_deg = position->longitude_deg;
      // From the first one the short way round: the date line may run through the block.
      const double from_first_deg = std::remainder(position->longitude_deg - first_longitude_deg, 360);
      sum.head<2>() += Eigen::Vector2d(position->latitude_deg, from_first_deg);
      if (!std::isfinite(position->sigma_m.z())) continue;
      sum.z() += position->height_m;
      ++heights;
    }
  return {sum.x() / std::max(1, count), std::remainder(first_longitude_deg + sum.y() / std::max(1, count), 360),
          sum.z() / std::max(1, heights)};
}

// Where the map's heights are stated beside its CRS, and those of control beside both.
struct Systems {
  std::string map, control;
};

Result<Systems> systems_of(const ImportOptions& options, const std::string& map, const std::string& control) {
  Systems systems{map, control};
  if (options.heights) {
    COLLINEA_TRY(systems.map, with_heights(map, *options.heights).map_error([](Error error) {
      return std::move(error).about("heights"_option);
    }));
  }
  if (options.control_heights) {
    COLLINEA_TRY(systems.control,
                 with_heights(control.empty() ? map : control, *options.control_heights).map_error([](Error error) {
                   return std::move(error).about("control_heights"_option);
                 }));
  } else if (options.heights && !control.empty()) {
    COLLINEA_TRY(const bool is_stated, states_heights(control));
    if (!is_stated) {
      COLLINEA_TRY(systems.control, with_heights(control, *options.heights));
    }
  }
  return systems;
}

bool has_positions(const Block& block) {
  return std::any_of(block.images.begin(), block.images.end(),
                     [](const auto& entry) { return entry.second.position.has_value(); });
}

}  // namespace

Result<> raise_positions(Imported& imported, const std::set<ImageId>& of_file, const ImportOptions& options) {
  if (options.gps_heights.word() == HeightSurface::kEllipsoid || !has_positions(imported.block)) return {};
  const Eigen::Vector3d middle = middle_of(imported.block);
  const auto framed = [](Error error) { return std::move(error).about("gps_heights"_option); };
  COLLINEA_TRY(const std::string crs,
               with_heights(utm_crs(middle.x(), middle.y()), options.gps_heights).map_error(framed));
  COLLINEA_TRY(const LocalFrame frame, LocalFrame::create(crs, middle.x(), middle.y(), 0).map_error(framed));
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (auto& [id, image] : imported.block.images) {
    if (!image.position || of_file.contains(id)) continue;
    const double raised_m = -frame
                                 .map_from_local(frame.local_from_geographic(
                                     {image.position->latitude_deg, image.position->longitude_deg, 0}))
                                 .z();
    if (!std::isfinite(raised_m))
      return fail(Errc::kBadInput,
                  "the geoid grid of the heights in the photographs does not reach the position of " + image.file,
                  {"gps_heights"_option});
    image.position->height_m += raised_m;
    least = std::min(least, raised_m);
    most = std::max(most, raised_m);
  }
  if (least > most) return {};
  const std::string heights = frame.crs_name().substr(frame.crs_name().find(" + ") + 3);
  imported.findings.push_back(finding_of(FindingCode::kHeightsCountFrom, {Subject::crs(heights)},
                                         {{FigureName::kLowest, least}, {FigureName::kHighest, most}}));
  return {};
}

Result<> location_on_earth(Imported& imported, const ImportOptions& options, ControlFile control) {
  Block& block = imported.block;
  const bool has_gps = has_positions(block);
  std::string crs = options.crs.value_or(control.crs);
  if (options.crs)
    if (const auto known = check_crs(crs); !known)
      return tl::unexpected(Error(known.error()).within("CRS \"" + crs + "\"").about("crs"_option));
  Eigen::Vector3d origin = middle_of(block);
  if (has_gps && crs.empty()) crs = utm_crs(origin.x(), origin.y());
  if (!has_gps) {
    if (!is_surveyed(control)) return add_control(imported, control, nullptr);
    if (crs.empty())
      return fail(Errc::kBadInput, "the control file names no CRS and the photographs have no GPS: give one, EPSG:code",
                  {"crs"_option});
  }
  COLLINEA_TRY(const Systems systems, systems_of(options, crs, control.crs));
  crs = systems.map;
  control.crs = systems.control;
  if (!has_gps) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const ControlFilePoint& point : control.points)
      middle += point.position_in_map / double(control.points.size());
    COLLINEA_TRY(origin, geographic_from_map(control.crs.empty() ? crs : control.crs, middle));
  }
  origin = {std::round(origin.x() * 1e5) / 1e5, std::round(origin.y() * 1e5) / 1e5, std::round(origin.z())};
  COLLINEA_TRY(const LocalFrame frame,
               LocalFrame::create(crs, origin.x(), origin.y(), origin.z()).map_error([&](Error error) {
                 Error framed = std::move(error).within("CRS \"" + crs + "\"");
                 return options.crs ? std::move(framed).about("crs"_option) : framed;
               }));
  block.georeference = Georeference{crs, origin.x(), origin.y(), origin.z()};
  for (auto& [id, image] : block.images)
    if (auto& prior = image.position)
      prior->position_in_world =
          frame.local_from_geographic({prior->latitude_deg, prior->longitude_deg, prior->height_m});
  return add_control(imported, control, &frame);
}

}  // namespace collinea
