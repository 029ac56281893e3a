// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/geopackage.h"
#include "collinea/vector/vector_areas.h"
#include "target.h"

namespace collinea::fuzz {
namespace {

std::string geopackage() {
  const std::vector<Eigen::Vector3d> square = {{0, 0, 0}, {0, 10, 0}, {10, 10, 0}, {10, 0, 0}};
  const std::vector<Eigen::Vector3d> hole = {{2, 2, 0}, {3, 2, 0}, {3, 3, 0}};
  const VectorLayer layer{"seamlines",
                          VectorKind::kPolygon,
                          {{"photo", VectorType::kText}},
                          {{square, {std::string("a.jpg")}, {hole}}, {hole, {std::string("b.jpg")}}},
                          true};
  if (!write_geopackage(folder() / "seed.gpkg", {layer}, "")) return "";
  return bytes_of(folder() / "seed.gpkg");
}

}  // namespace

std::vector<Target> vector_targets() {
  return {{"geopackage",
           [](std::string_view bytes) { return read_areas(file_of(bytes, "a.gpkg"), "photo", "").has_value(); },
           {geopackage()}}};
}

}  // namespace collinea::fuzz
