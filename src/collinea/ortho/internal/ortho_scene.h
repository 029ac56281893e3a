// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/ortho/internal/visibility.h"
#include "collinea/radiometry/exposure.h"

namespace collinea {

struct SeamPlan;

/// Everything that the tiles of one orthophoto share.
struct OrthoScene {
  MapGrid grid;  ///< of the orthophoto
  const HeightField* surface = nullptr;
  const HeightOverview* surface_overview = nullptr;
  const LocalFrame* frame = nullptr;  ///< null: map and world are the same
  std::vector<View> views;
  std::vector<int> shrink;  ///< at which size each view's image is read
  ColourBalance balance;
  PixelCache* images = nullptr;
  int feather_cells = 12;
  const HeightField* terrain = nullptr;  ///< null: not known; tells what is raised, where seams should not run
  const SeamPlan* seams = nullptr;       ///< null: every cell takes the cheapest view
  std::filesystem::path scratch = {};    ///< beside it what is unpacked lies for a while; empty: nothing is
};

/// For each view the largest reduction of its image at which a pixel still is no larger than a cell.
[[nodiscard]] std::vector<int> shrinks(const OrthoScene& scene, double cell_m);

/// A piece of the scene's grid with its heights, and in `views` those that show something of it; nothing where there
/// are no heights or no view shows anything. Errors: the surface cannot be read.
[[nodiscard]] Result<std::optional<OrthoPatch>> make_patch(const OrthoScene& scene, const CellArea& area,
                                                           std::vector<std::size_t>& views);

}  // namespace collinea
