// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/seamlines_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/import/image_names.h"
#include "collinea/vector/geopackage.h"

namespace collinea {
namespace {

std::vector<Eigen::Vector3d> flat_positions(const MapRing& ring) {
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector2d& position : ring) positions.emplace_back(position.x(), position.y(), 0);
  return positions;
}

}  // namespace

Result<> write_seamlines(const std::filesystem::path& path, const std::vector<SeamPolygon>& seamlines,
                         const Block& block, std::span<const ImageId> sources, const std::string& wkt) {
  VectorLayer layer{"seamlines", VectorKind::kPolygon, {{"photo", VectorType::kText}}, {}, /*flat=*/true};
  for (const SeamPolygon& polygon : seamlines) {
    VectorRow row{flat_positions(polygon.rings.front()), {block.images.at(sources[polygon.source - 1u]).file}};
    for (std::size_t i = 1; i < polygon.rings.size(); ++i) row.holes.push_back(flat_positions(polygon.rings[i]));
    layer.rows.push_back(std::move(row));
  }
  return write_geopackage(path, {layer}, wkt);
}

Result<std::vector<SeamPolygon>> read_seamlines(const std::filesystem::path& path, const Block& block,
                                                std::span<const ImageId> sources, const std::string& wkt) {
  COLLINEA_TRY(std::vector<NamedArea> areas, read_areas(path, "photo", wkt));
  const ImageNames names(block);
  std::vector<SeamPolygon> seamlines;
  for (NamedArea& area : areas) {
    const auto refused = [&](const char* why) {
      return fail(Errc::kBadInput, fmt::format("{}: feature {}: {}{}", path.string(), area.feature, area.name, why));
    };
    const auto image = names.find(area.name);
    if (!image) return refused(" is no photograph of the project");
    const auto found = std::find(sources.begin(), sources.end(), *image);
    if (found == sources.end()) return refused(" is not oriented: it cannot be a source of the orthophoto");
    seamlines.push_back({std::uint16_t(found - sources.begin() + 1), std::move(area.rings)});
  }
  return seamlines;
}

}  // namespace collinea
