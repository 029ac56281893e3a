// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>

#include "collinea/base/run.h"
#include "collinea/radiometry/view.h"
#include "collinea/surface/height_field.h"

namespace collinea {

/// Differences of heights, estimated minus true [m].
struct HeightErrors {
  std::size_t cells = 0;
  double mean_m = 0, rmse_m = 0;
  double median_m = 0, nmad_m = 0;  ///< robust: nmad = 1.4826 times the median distance from the median
  double share_gross = 0;           ///< of the cells off by more than three cells of the surface model
};

struct SurfaceErrors {
  double cell_m = 0;           ///< of the assessed model
  HeightErrors overall;        ///< cells with a height in both
  HeightErrors smooth_ground;  ///< of these, where the true slope is below 0.3 and no step lies within 3 cells
  HeightErrors smooth_measured, smooth_interpolated;  ///< parts of smooth_ground; no cells when it is not known which
  double completeness = 0;                            ///< share of the true surface with a height in the model
  double completeness_measured = 0;  ///< the same, interpolated cells not counted; equal when it is not known which
  double completeness_seen = 0;      ///< share where at least three images see the true surface; 0 without views
  std::size_t cells_seen = 0;        ///< looked at for that
  HeightErrors
      roofs;  ///< measured cells on objects more than a metre high, no step within 3 cells; none without terrain
  std::size_t bounds = 0;          ///< measured cells of smooth ground and roofs whose sigma was looked at
  double within_bounds = 0;        ///< of these, the share whose error is below kBoundSigmas
  double roofs_within_bounds = 0;  ///< the same of those of roofs
  /// The same of every 16th of all when the plane that fits their errors best is taken off (take_off_plane); nothing
  /// where there is none.
  std::optional<double> levelled_within_bounds;
};

/// Bytes of a raster by windows, as HeightField::read.
using StateReader = std::function<Result<Raster<std::uint8_t>>(int column, int row, int width, int height)>;

/// Compares a surface model with the true one at the centres of the model's cells; both in the same map. `state`:
/// CellState of the model, or null. `views`: the true cameras, or none. `terrain`: the true ground, on the grid of
/// `truth`. Sigmas are looked at where the model has them. Errors: reading; rasters do not overlap;
/// cancelled.
[[nodiscard]] Result<SurfaceErrors> surface_errors(const HeightField& model, const StateReader& state,
                                                   const HeightField& truth, std::span<const View> views,
                                                   const LocalFrame* frame, const Run& run,
                                                   const HeightField* terrain = nullptr);

struct TerrainErrors {
  double cell_m = 0;
  HeightErrors overall;                 ///< cells with a height in both
  HeightErrors measured, interpolated;  ///< of these: the ground was seen; it was continued
  std::size_t object_cells = 0;         ///< where something stands more than a metre above the ground
  double share_removed = 0;             ///< of these, nearer to the ground than to the top of what stands there
};

/// Compares a terrain model with the true terrain at the centres of its cells; all in the same map. `state`: CellState,
/// measured where the ground was seen. `surface`: the true surface on the grid of `terrain`. Errors: reading; rasters
/// do not overlap; cancelled.
[[nodiscard]] Result<TerrainErrors> terrain_errors(const HeightField& model, const StateReader& state,
                                                   const HeightField& terrain, const HeightField& surface,
                                                   const Run& run);

/// The statistics of a list of differences. Reorders it.
[[nodiscard]] HeightErrors height_errors(std::vector<float>& differences_m, double gross_m);

}  // namespace collinea
