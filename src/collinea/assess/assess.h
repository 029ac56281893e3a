// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/assess/internal/cloud_errors.h"
#include "collinea/assess/internal/colour_errors.h"
#include "collinea/assess/internal/ortho_errors.h"
#include "collinea/assess/internal/pose_errors.h"
#include "collinea/assess/internal/surface_errors.h"
#include "collinea/assess/internal/wall_errors.h"
#include "collinea/base/run.h"
#include "collinea/synthetic/write.h"

namespace collinea {

/// The products to be assessed; paths that are empty or do not exist are left out.
struct ProductFiles {
  std::filesystem::path cloud, dsm, dsm_state, dsm_sigma, dsm_sigma_relative, dtm, dtm_state, ortho, ortho_source;
};

/// How far the results of a simulated block are from the truth.
struct Assessment {
  PoseErrors poses;
  std::optional<PointErrors> check_points, control_points;  ///< nothing without such marks or without georeference
  std::optional<CloudErrors> cloud;
  std::optional<SurfaceErrors> surface;
  std::optional<double> relative_within_bounds;  ///< as SurfaceErrors::levelled_within_bounds, by the relative sigmas
  std::optional<WallErrors> walls;
  std::optional<TerrainErrors> terrain;
  std::optional<OrthoErrors> ortho;
  std::optional<ColourErrors> ortho_colours;
  std::optional<double> gsd_m;  ///< cell of the true rasters
};

/// Compares a block and its products with the folder that `simulate` wrote. Errors: files that exist cannot be read;
/// the block's CRS is unknown; cancelled.
[[nodiscard]] Result<Assessment> assess(const Block& block, const ProductFiles& products, const TruthFolder& truth,
                                        const Run& run);

}  // namespace collinea
