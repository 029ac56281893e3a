// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/import_control.h"

#include <fmt/format.h>

#include "collinea/pipeline/image_names.h"

namespace collinea {
namespace {

// Points surveyed in another CRS than the map's come by way of geographic coordinates.
Result<Eigen::Vector3d> in_world(const ControlFilePoint& point, const std::string& crs, const LocalFrame& frame) {
  if (crs.empty() || crs == frame.crs()) return frame.local_from_map(point.position_in_map);
  return geographic_from_map(crs, point.position_in_map)
      .map([&](const Eigen::Vector3d& geographic) { return frame.local_from_geographic(geographic); })
      .map_error([&](Error error) { return std::move(error).within("control " + point.name); });
}

}  // namespace

Result<> add_control(Imported& imported, const ControlFile& control, const LocalFrame& frame) {
  Block& block = imported.block;
  std::map<std::string, ControlId> by_name;
  for (const ControlFilePoint& point : control.points) {
    const ControlId id{static_cast<std::uint32_t>(block.control.size())};
    by_name[point.name] = id;
    COLLINEA_TRY(const Eigen::Vector3d world, in_world(point, control.crs, frame));
    block.control[id] = {point.name, point.role, frame.map_from_local(world), world, point.sigma_m};
  }
  const ImageNames images(block);
  std::map<std::string, int> missing;
  std::map<ControlId, int> seen;
  for (const ControlFileObservation& row : control.observations) {
    const auto image = images.find(row.file);
    if (!image) {
      ++missing[row.file];
      continue;
    }
    if (!inside(block.camera_of(*image), row.pixel)) {
      imported.findings.push_back(
          fmt::format("control {} in {} (line {}): pixel {:.1f}, {:.1f} lies outside the picture; left out", row.point,
                      row.file, row.line, row.pixel.x(), row.pixel.y()));
      continue;
    }
    const ControlId point = by_name.at(row.point);
    ++seen[point];
    block.control_observations.push_back({point, *image, row.pixel, row.sigma_px});
  }
  for (const auto& [file, rows] : missing)
    imported.findings.push_back(
        fmt::format("control file: no photograph is called {} ({} measurements left out)", file, rows));
  for (const auto& [id, point] : block.control)
    if (seen[id] < 2)
      imported.findings.push_back(fmt::format("control {} is seen in {} image{}: it cannot be used", point.name,
                                              seen[id], seen[id] == 1 ? "" : "s"));
  return {};
}

}  // namespace collinea
