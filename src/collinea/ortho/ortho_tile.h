// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "collinea/ortho/internal/ortho_scene.h"
#include "collinea/ortho/internal/seams.h"

namespace collinea {

/// How well the images agree along seams: sides between neighbouring cells of different views, colours after
/// balancing.
struct SeamAgreement {
  struct Step {
    std::uint64_t sides = 0;
    double grey_levels = 0;  ///< sum over the sides: second view less first

    template <class Visit>
    static void fields(Visit&& visit) {
      visit("sides", &Step::sides);
      visit("grey_levels", &Step::grey_levels);
    }
  };
  std::uint64_t sides = 0;
  double difference_grey = 0;                        ///< sum over the sides: mean over channels, without sign
  std::map<std::array<std::size_t, 2>, Step> steps;  ///< by indices of the two views

  void add(const SeamAgreement& other);

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("sides", &SeamAgreement::sides);
    visit("difference_grey", &SeamAgreement::difference_grey);
    visit("steps", &SeamAgreement::steps);
  }
};

struct OrthoTile {
  Raster<std::uint8_t> rgba;                               ///< alpha 0: no height, or no view sees the point; else 255
  Raster<std::uint16_t> source;                            ///< 1 + index of the view that leads; 0: none
  SeamAgreement seams;                                     ///< sides to the east and the south of the tile's cells
  std::map<std::size_t, std::uint64_t> not_followed = {};  ///< by views that the plan names: cells that another leads
};

/// How far around a tile the plan of the seams has a say in it [cells].
constexpr int kOrthoTileReach = 48;

/// A piece of the orthophoto; column and row are multiples of OrthoPatch::kBlock. What a cell becomes depends only on
/// its surroundings, not on the tile it lies in. Errors: an image or the surface cannot be read; cancelled.
[[nodiscard]] Result<OrthoTile> make_ortho_tile(const OrthoScene& scene, int column, int row, int width, int height,
                                                const Run& run);

/// The side of the tiles in which an orthophoto is made.
constexpr int kOrthoTile = 1024;

/// The colour at a position in an image [px] by bicubic convolution (Keys 1981), clamped at the border; three channels.
void bicubic(const ColourImage& image, double x, double y, float colour[3]);

}  // namespace collinea
