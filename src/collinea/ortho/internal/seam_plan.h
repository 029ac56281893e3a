// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/ortho/internal/ortho_scene.h"
#include "collinea/ortho/internal/seam_window.h"
#include "collinea/ortho/seamlines.h"

namespace collinea {

/// Which view each cell of the orthophoto is to be taken from, if that view sees it: found, or given.
struct SeamPlan {
  static constexpr int kCoarse = SeamWindow::kCoarse;  ///< cells of the orthophoto along a cell of the plan

  Raster<std::uint16_t> source;           ///< found: 1 + index of the view; 0: none
  std::vector<SeamPolygon> given;         ///< instead, when source is empty
  std::vector<SeamPolygon> patches = {};  ///< over either, the later ones on top

  /// What is wanted in a part of the orthophoto's grid, also beside it; and, where given polygons overlap, what is
  /// wanted next if the first cannot be had.
  struct Part {
    Raster<std::uint16_t> source, below;
  };
  [[nodiscard]] Part part(const MapGrid& grid, const CellArea& area) const;
};

/// The grid of a plan.
[[nodiscard]] MapGrid plan_grid(const MapGrid& orthophoto);

/// Finds the seams of least energy (SeamWindow): a draft on a grid four times as coarse as the plan's, on which windows
/// of work are so large that few seams meet their borders (and those windows are shifted and cut again); then on the
/// grid of the plan, from the draft on, among the views that this has nearby and the best few. The windows are fixed to
/// the grid of the orthophoto: the plan depends neither on threads nor on how the orthophoto is cut into tiles.
/// Holds one window per thread and two bytes for 16 cells of the orthophoto. Errors: an image or the surface cannot be
/// read; cancelled.
[[nodiscard]] Result<SeamPlan> plan_seams(const OrthoScene& scene, const Run& run);

}  // namespace collinea
