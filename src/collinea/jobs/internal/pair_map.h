// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "collinea/block/block.h"
#include "collinea/cloud/ply.h"
#include "collinea/report/pair_report.h"
#include "collinea/surface/dsm.h"

namespace collinea {

/// A pair with its orientation in a metric frame whose z is up.
struct MappedPair {
  std::array<std::filesystem::path, 2> files;
  std::array<Camera, 2> cameras;          ///< of the files
  std::array<Rigid3, 2> cam_from_ground;  ///< [m]
};

/// The surface model and the true orthophoto of a pair: dsm.tif, dsm_sigma.tif, dsm_state.tif, dsm_count.tif,
/// dsm_sigma_relative.tif, ortho.tif, ortho_source.tif and dsm_hillshade.tif in the folder. `cloud` lies in the frame
/// of the pair, with the sigmas of matching; `by_orientation` is what the orientation adds to those of heights. Nothing
/// where the images do not look down.
/// Cell: given, else the larger of the ground size of a pixel (`gsd_m`) and the mean distance of points. Errors: a cell
/// far smaller than that distance; disk, stopped.
[[nodiscard]] Result<std::optional<PairMap>> map_pair(const MappedPair& pair, const std::vector<CloudPoint>& cloud,
                                                      const std::vector<PositionSigma>& by_orientation, double gsd_m,
                                                      std::optional<double> cell_m, const std::filesystem::path& folder,
                                                      const Run& run);

}  // namespace collinea
