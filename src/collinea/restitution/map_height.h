// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <optional>

#include "collinea/geodesy/local_frame.h"
#include "collinea/marking/marking_block.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// The height of the surface at a position of the map; nothing where none is known.
using MapHeight = std::function<std::optional<double>(const Eigen::Vector2d& on_map)>;

/// Those of a raster (height_at()), of which only the tiles of kHeightTile cells are read that positions fall into: of
/// the kMostHeightTiles last ones, 4 MiB, none is read twice. What cannot be read has no height. Not for several
/// threads at once; copies share what was read.
[[nodiscard]] MapHeight heights_by_need(const HeightField& field);
/// Those of a raster in a file. Empty: it is not there, or cannot be read.
[[nodiscard]] MapHeight heights_by_need(const std::filesystem::path& raster);
inline constexpr int kHeightTile = 128;
inline constexpr std::size_t kMostHeightTiles = 64;

/// The same in the world, for what the surface hides there. `frame`: null where the map is the world. Empty: as
/// `surface`.
[[nodiscard]] SurfaceHeight surface_in_world(const LocalFrame* frame, const MapHeight& surface);

}  // namespace collinea
