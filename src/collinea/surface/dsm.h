// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/raster/geotiff.h"
#include "collinea/surface/internal/gridding.h"
#include "collinea/surface/internal/orientation_sigma.h"

namespace collinea {

/// A point of the fused cloud, as far as the surface model needs it.
struct SurfacePoint {
  Eigen::Vector3d position;  ///< in the world or on the map, see PointFrame [m]
  float sigma_m = 0;         ///< of its height; 0: unknown, taken as half a cell
  std::uint8_t images = 0;   ///< that agree on it; 0: unknown
};

/// In which coordinates points come. From files they often are on the map already.
enum class PointFrame { kWorld, kMap };

/// Hands out a cloud batch by batch: replaces the contents of `batch` with the next points (some 100,000 at once);
/// leaves it empty at the end.
using PointSource = std::function<Result<>(std::vector<SurfacePoint>& batch)>;

struct DsmOptions {
  std::optional<double> cell_m;        ///< nothing: the ground size of a pixel of the images that were matched
  std::optional<double> fill_holes_m;  ///< nothing: 250 cells

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = DsmOptions;
    visit(Field{"cell_m", &O::cell_m, "m", "cell of the surface model; else the ground size of a matched pixel", 1e-6});
    visit(Field{"fill_holes_m", &O::fill_holes_m, "m", "holes up to this width are filled and marked; else 250 cells",
                0.0});
  }
};

/// Where the rasters go. All have the same grid.
struct DsmFiles {
  std::filesystem::path height;          ///< float, m; no data -9999
  std::filesystem::path sigma;           ///< float, m; no data -9999
  std::filesystem::path state;           ///< byte: 0 nothing, 1 measured, 2 interpolated
  std::filesystem::path count;           ///< 16 bit: points that made the cell
  std::filesystem::path sigma_relative;  ///< float, m: sigma without what the orientation adds; no data -9999
};

struct DsmSummary {
  MapGrid grid;
  std::uint64_t points = 0;          ///< read
  std::uint64_t points_dropped = 0;  ///< not finite, or far from all others
  std::uint64_t measured_cells = 0, interpolated_cells = 0, empty_cells = 0;
  double lowest_m = 0, highest_m = 0;                  ///< of the measured cells; 0 when there are none
  double mean_sigma_m = 0, mean_sigma_relative_m = 0;  ///< quadratic means of the measured cells
};

/// Takes the model piece by piece, as build_dsm makes it: windows of one grid, from the upper left, row by row.
struct SurfaceSink {
  std::function<Result<>(const MapGrid& grid)> begin;
  std::function<Result<>(int column, int row, const SurfaceTile& tile)> take;
};

/// A cloud, and what is known of it.
struct SurfaceCloud {
  PointSource points;
  const LocalFrame* frame = nullptr;  ///< of the world on the map; null: the map is the plane x, y of the world
  PointFrame point_frame = PointFrame::kWorld;  ///< does not matter without `frame`
  /// Ground size of a pixel of the matched images: says over what distance errors of points are alike, and so how
  /// little of them many points in a cell average out; the cell, where none is asked for. 0: not known; errors are
  /// taken as independent, and the cell has to be given.
  double gsd_m = 0;
  std::vector<PositionSigma>
      position_sigmas;   ///< what images and cameras add to the sigmas of heights; none: nothing is known
  std::string wkt = {};  ///< of the CRS, where there is no `frame`: of a plane of an object
};

/// The surface model of a cloud: per cell the height of the uppermost surface (see CellFit). Cell edges lie on
/// multiples of the cell size. Sigmas are those of the points and, beside them, of `position_sigmas`. Points and
/// measured cells are kept in `scratch` beyond 64 MB and 16 MB. The same cloud gives the same bits in any order and
/// with any number of threads. Errors: no points, raster too large, disk, cancelled.
Result<DsmSummary> build_dsm(const SurfaceCloud& cloud, const SurfaceSink& sink, const std::filesystem::path& scratch,
                             const DsmOptions& options, const Run& run);

/// The same, written to GeoTIFFs.
Result<DsmSummary> build_dsm(const SurfaceCloud& cloud, const DsmFiles& files, const std::filesystem::path& scratch,
                             const DsmOptions& options, const Run& run);

/// A size rounded to two significant digits: 0.02371 -> 0.024.
[[nodiscard]] double tidy_cell_m(double gsd_m);

}  // namespace collinea
