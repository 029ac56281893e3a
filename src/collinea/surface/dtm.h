// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <utility>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/surface/dsm.h"

namespace collinea {

struct DtmOptions {
  double largest_object_m = 40;
  std::optional<double> contour_m;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = DtmOptions;
    visit(Field{"largest_object_m", &O::largest_object_m, "m",
                "buildings, trees and all else up to this width is taken from the ground", 0.01, 1000});
    visit(Field{"contour_m", &O::contour_m, "m",
                "interval of the contours; else by relief and accuracy; 0: no contours", 0.0});
  }
};

struct DtmFiles {
  std::filesystem::path height;    ///< float, m; no data -9999
  std::filesystem::path sigma;     ///< float, m; no data -9999
  std::filesystem::path state;     ///< byte: 0 nothing, 1 ground as measured, 2 interpolated under an object or a gap
  std::filesystem::path contours;  ///< GeoPackage and, beside it with the ending .dxf, DXF
  std::filesystem::path sigma_relative;  ///< float, m: sigma without what the orientation adds; no data -9999
};

struct DtmSummary {
  MapGrid grid;  ///< that of the surface model
  std::uint64_t ground_cells = 0, interpolated_cells = 0, empty_cells = 0;
  double coarse_cell_m = 0;  ///< of the grid on which objects are told from the ground
  double lowest_m = 0, highest_m = 0;
  double mean_sigma_m = 0, mean_sigma_relative_m = 0;  ///< quadratic means over ground cells
  double contour_m = 0;                                ///< interval taken; 0: none
  std::uint64_t contours = 0;                          ///< lines
};

/// Where the ground is, to about half a cell of a coarse grid: tells what shows the ground from what stands on it.
class GroundSurface {
 public:
  GroundSurface() = default;
  /// `low_m`: low heights of the ground, one for every cell of `grid`.
  GroundSurface(MapGrid grid, FloatImage low_m) : grid_(std::move(grid)), low_m_(std::move(low_m)) {}

  /// Whether a measured height shows the ground: no farther from it than half a cell, the slope's part and three
  /// sigmas, of which a cell counts at most. `column` and `row` are continuous, in coarse cells.
  [[nodiscard]] bool shows_ground(double column, double row, double height_m, double sigma_m) const;
  /// The same of a point on the map; false outside the grid.
  [[nodiscard]] bool shows_ground(const Eigen::Vector3d& on_map, double sigma_m) const;

 private:
  [[nodiscard]] double tolerance_m(int u, int v) const;  // in a cell, without sigmas

  MapGrid grid_;
  FloatImage low_m_;
};

/// What people say of what is seen at a position of the map: whether it shows the ground; nothing: they say nothing.
using GroundByHand = std::function<std::optional<bool>(const Eigen::Vector3d& on_map)>;

/// A terrain model that was written, and what points of the cloud can be classified with.
struct Dtm {
  DtmSummary summary;
  GroundSurface ground;
};

/// The terrain model of a surface model: heights of the ground, as measured where the ground is seen (see
/// GroundSurface), and interpolated from around under buildings, trees and whatever else stands on it (ground_cells).
/// It covers what the surface model covers. Contours are those of the coarse grid's means. Memory: 20 bytes
/// for each cell of the coarse grid, at most 64 million, and pieces of the rasters. Where `by_hand` (may be empty) says
/// what a measured cell shows, that holds, and the ground around follows it. The same bits with any number of
/// threads. Errors: no ground at all; reading; disk; cancelled.
Result<Dtm> build_dtm(const DsmFiles& dsm, const DtmFiles& files, const DtmOptions& options, const Run& run,
                      const GroundByHand& by_hand = {});

}  // namespace collinea
