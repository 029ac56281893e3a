// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/cloud/ply.h"
#include "collinea/report/pair_report.h"

namespace collinea {

/// A pair with its orientation in a metric frame whose z is up.
struct MappedPair {
  std::array<std::filesystem::path, 2> files;
  std::array<Camera, 2> cameras;          ///< of the files
  std::array<Rigid3, 2> cam_from_ground;  ///< [m]
};

/// The cloud of a pair, as it lies on disk.
struct MappedCloud {
  std::filesystem::path file;  ///< of PlyWriter
  Similarity3 map_from_file;   ///< to the frame of the pair
  std::size_t points = 0;
  double distance_m = 0;  ///< mean, of points
  double pixel_m = 1;     ///< on the ground, of the images that were matched
};

/// The surface model and the true orthophoto of a pair: dsm.tif, dsm_sigma.tif, dsm_state.tif, dsm_count.tif,
/// ortho.tif, ortho_source.tif and dsm_hillshade.tif in the folder. The sigmas of heights are those of matching,
/// without what the orientation adds. Nothing where the images do not look down. Cell: given, else the larger of the
/// ground size of a pixel and the mean distance of points. Nothing but these files is left in the folder, whatever
/// happens. Errors: a cell far smaller than that distance; disk, stopped.
[[nodiscard]] Result<std::optional<PairMap>> map_pair(const MappedPair& pair, const MappedCloud& cloud,
                                                      std::optional<double> cell_m, const std::filesystem::path& folder,
                                                      const Run& run);

}  // namespace collinea
