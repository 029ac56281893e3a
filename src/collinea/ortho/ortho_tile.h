// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/ortho/exposure.h"
#include "collinea/ortho/seams.h"

namespace collinea {

/// Everything that the tiles of one orthophoto share.
struct OrthoScene {
  MapGrid grid;  ///< of the orthophoto
  const HeightField* surface = nullptr;
  const HeightOverview* surface_overview = nullptr;
  const LocalFrame* frame = nullptr;  ///< null: map and world are the same
  std::vector<View> views;
  std::vector<int> shrink;          ///< at which size each view's picture is read
  std::vector<Exposure> exposures;  ///< of each view
  PixelCache* pictures = nullptr;
  int feather_cells = 12;
};

struct OrthoTile {
  Raster<std::uint8_t> rgba;     ///< alpha 0: no height, or no view sees the place; else 255
  Raster<std::uint16_t> source;  ///< 1 + index of the view that leads; 0: none
};

/// A piece of the orthophoto; column and row are multiples of OrthoPatch::kBlock. What a cell becomes depends only on
/// its surroundings, not on the tile it lies in. Errors: a picture or the surface cannot be read; cancelled.
[[nodiscard]] Result<OrthoTile> make_ortho_tile(const OrthoScene& scene, int column, int row, int width, int height,
                                                const Run& run);

/// The side of the tiles in which an orthophoto is made.
constexpr int kOrthoTile = 1024;

/// The colour at a place of a picture [px] by bicubic convolution (Keys 1981), clamped at the border; three channels.
void bicubic(const ColourImage& picture, double x, double y, float colour[3]);

}  // namespace collinea
