// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/block/image_masks.h"
#include "collinea/ortho/kept_orthophoto.h"
#include "collinea/ortho/ortho_tile.h"
#include "collinea/ortho/seamlines.h"
#include "collinea/radiometry/exposure.h"

namespace collinea {

struct OrthoOptions {
  std::optional<double> cell_m;  ///< nothing: the ground size of a pixel of the images
  int feather_cells = 12;
  bool balance = true;
  std::optional<std::filesystem::path> seamlines;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = OrthoOptions;
    visit(Field{"cell_m", &O::cell_m, "m", "cell of the orthophoto; else the ground size of a pixel", 1e-6});
    visit(Field{"feather_cells", &O::feather_cells, "cells", "width of the zone along seams in which images are mixed",
                2, 24});
    visit(Field{"seamlines", &O::seamlines, "",
                "take each polygon of this GeoPackage from the photograph that its field \"photo\" names, wherever "
                "that sees it (an edited products/seamlines.gpkg); nothing: find the seams"}
              .leads_to(PathKind::kFile));
    visit(Field{"balance", &O::balance, "1", "make the brightness and colour of the photographs alike"});
  }
};

/// What is known of where seams should run.
struct SeamGuides {
  const ImageMasks* masks = nullptr;     ///< parts of images that are taken nowhere
  const HeightField* terrain = nullptr;  ///< seams avoid what stands above it; null: not known
  const std::vector<SeamPolygon>* given =
      nullptr;                            ///< where they are to run; sources by OrthoSummary::sources; null: find
  std::vector<SeamPolygon> patches = {};  ///< lie over these or those, the later ones on top
  /// Made of the same but for patches: only what these change is made anew, the rest is taken from it; null: none.
  const EarlierOrthophoto* earlier = nullptr;
};

struct OrthoFiles {
  std::filesystem::path image;   ///< red, green, blue, alpha; Cloud-Optimised GeoTIFF
  std::filesystem::path source;  ///< 16 bit: 1 + index in OrthoSummary::sources of the leading image; 0 none
};

struct OrthoSummary {
  MapGrid grid;
  std::vector<ImageId> sources;  ///< all oriented images, by id
  KeptOrthophoto kept;           ///< with the colour balance of the sources
  std::uint64_t kept_tiles = 0;  ///< taken from an earlier one
  std::uint64_t painted_cells = 0, empty_cells = 0;
  std::uint64_t images_used = 0;
  std::vector<SeamPolygon> seamlines;  ///< the plan, patches last: sources are indices in `sources`, from 1 on
  std::map<std::size_t, std::uint64_t>
      not_followed;                 ///< by index in `sources`: cells planned for it that it does not see
  double seam_length_m = 0;         ///< where both images see the point
  double seam_difference_grey = 0;  ///< mean over the seams: by how much the two images differ, after balancing
  double seam_step_grey = 0;        ///< root mean square over the seams: mean step between the two images of a pair
};

/// Takes the orthophoto piece by piece: windows of one grid, from the upper left, row by row.
struct OrthoSink {
  std::function<Result<>(const MapGrid& grid)> begin;
  std::function<Result<>(int column, int row, const OrthoTile& tile)> take;
  std::filesystem::path scratch = {};  ///< beside it what is unpacked lies for a while; empty: slower
};

/// The true orthophoto: each cell of the map takes the colour of its position on the surface, from the image that
/// sees it most from above and is not hidden by the surface; images are mixed in a narrow zone along the seams.
/// Seams run as given, or are found (plan_seams); patches lie over them. Cells that no image sees, and cells without
/// height, stay transparent: nothing is copied from the wrong surface. `frame`: null when the surface model lies in the
/// plane x, y of the world. `gsd_m`: ground size of a pixel of the images. Holds at most about 512 MB of decoded
/// images, or two of them where these are larger. Same bits with any number of threads. Errors: an image cannot be
/// read, no oriented images, raster too large, cancelled.
Result<OrthoSummary> make_orthophoto(const Block& block, const LocalFrame* frame, const HeightField& surface,
                                     const SeamGuides& guides, const PixelSource& pixels, double gsd_m,
                                     const OrthoSink& sink, const OrthoOptions& options, const Run& run);

/// The same, written to GeoTIFFs.
Result<OrthoSummary> make_orthophoto(const Block& block, const LocalFrame* frame, const HeightField& surface,
                                     const SeamGuides& guides, const PixelSource& pixels, double gsd_m,
                                     const OrthoFiles& files, const OrthoOptions& options, const Run& run);

}  // namespace collinea
