// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/ortho/ortho_tile.h"
#include "collinea/ortho/seamlines.h"
#include "collinea/radiometry/exposure.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// What is counted of a tile of an orthophoto.
struct OrthoTally {
  std::uint64_t painted_cells = 0, empty_cells = 0;
  std::vector<std::uint16_t> used;  ///< 1 + index of views, ascending
  SeamAgreement seams;
  std::map<std::size_t, std::uint64_t> not_followed;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("painted_cells", &OrthoTally::painted_cells);
    visit("empty_cells", &OrthoTally::empty_cells);
    visit("used", &OrthoTally::used);
    visit("seams", &OrthoTally::seams);
    visit("not_followed", &OrthoTally::not_followed);
  }
};
[[nodiscard]] OrthoTally tally_of(const OrthoTile& tile);

/// A raster of sources, row by row, as runs of equal ones: seams are few.
struct SourceRuns {
  std::int32_t width = 0, height = 0;
  std::vector<std::uint32_t> lengths;
  std::vector<std::uint16_t> sources;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("width", &SourceRuns::width);
    visit("height", &SourceRuns::height);
    visit("lengths", &SourceRuns::lengths);
    visit("sources", &SourceRuns::sources);
  }
};
[[nodiscard]] SourceRuns runs_of(const Raster<std::uint16_t>& raster);
/// Nothing where the runs do not fill the raster.
[[nodiscard]] std::optional<Raster<std::uint16_t>> raster_of(const SourceRuns& runs);

/// What an orthophoto leaves for the next one of the same surface, photographs and options, that differs from it by
/// patches alone: all that is dear to find, but its pixels.
struct KeptOrthophoto {
  ColourBalance balance;
  SourceRuns plan;  ///< SeamPlan::source; of no cells: seamlines were given
  std::vector<SeamPolygon> patches;
  std::vector<OrthoTally> tallies;  ///< of the tiles, in their order

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("balance", &KeptOrthophoto::balance);
    visit("plan", &KeptOrthophoto::plan);
    visit("patches", &KeptOrthophoto::patches);
    visit("tallies", &KeptOrthophoto::tallies);
  }
};

/// An orthophoto made before, with its pixels. `read` gives a part of it; from several threads at once.
struct EarlierOrthophoto {
  KeptOrthophoto kept;
  std::function<Result<OrthoTile>(const CellArea& area)> read;
};

/// The patches that make one list another: those of one of the lists alone; all of both where the order of common ones
/// differs, for order tells which lies on top.
[[nodiscard]] std::vector<SeamPolygon> changed_patches(std::span<const SeamPolygon> before,
                                                       std::span<const SeamPolygon> after);

/// Whether a patch has a say in cells of an area.
[[nodiscard]] bool reaches(const SeamPolygon& patch, const MapGrid& grid, const CellArea& area);

}  // namespace collinea
