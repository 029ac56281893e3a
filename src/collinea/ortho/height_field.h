// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/image/geotiff.h"

namespace collinea {

/// A surface model that is read by windows. `read` takes windows inside the raster and gives NaN where there is no
/// height; it may be called from several threads at once.
struct HeightField {
  MapGrid grid;
  std::function<Result<FloatImage>(int column, int row, int width, int height)> read;
  std::function<Result<FloatImage>(int column, int row, int width, int height)> read_sigma = {};  ///< null: exact
};

/// A surface model in a GeoTIFF (no data value as stated in the file); with the standard deviations of its heights when
/// `sigma_path` is given and there.
[[nodiscard]] Result<HeightField> open_height_field(const std::filesystem::path& path,
                                                    const std::filesystem::path& sigma_path = {});

/// The same surface in cells `times` as large, each with the height of one cell near its middle: steps stay sharp.
/// Reads `field`, which must outlive it, in strips.
[[nodiscard]] HeightField thinned(const HeightField& field, int times);

/// A place of the surface, in continuous cells of its raster.
struct SurfacePlace {
  double column = 0, row = 0;
  float height_m = 0;
};

/// The surface in blocks of kBlock x kBlock cells: between which heights it lies.
struct HeightOverview {
  static constexpr int kBlock = 32;
  FloatImage lowest_m, highest_m;    ///< per block; NaN where no cell has a height
  std::vector<SurfacePlace> places;  ///< the cell nearest to the middle of each block, block by block
  double mean_m = 0;                 ///< of the places
};
[[nodiscard]] Result<HeightOverview> overview(const HeightField& field, const Run& run);

/// A window of the surface in memory. Positions are continuous cells of the window: the centre of its upper-left cell
/// is (0.5, 0.5).
class HeightWindow {
 public:
  HeightWindow() = default;
  /// `column`, `row`: of the upper-left cell of `heights_m` in the field. `sigma_m`: of the heights, or empty.
  HeightWindow(FloatImage heights_m, int column, int row, double cell_m, const FloatImage& sigma_m = {});

  [[nodiscard]] int column() const { return column_; }
  [[nodiscard]] int row() const { return row_; }
  [[nodiscard]] bool empty() const { return heights_m_.empty(); }

  /// The height at a place: bilinear on a smooth surface, of the nearest cell beside steps and holes (a slope between
  /// roof and ground would be painted with colours that belong to neither). NaN where the place has no height.
  [[nodiscard]] float at(double x, double y) const;

  /// True when the surface rises above the straight line from the place at height_m (on it or above) towards a camera
  /// at (camera_x, camera_y, camera_height_m), also when it is three of its sigmas lower (but no more than ten cells).
  /// One cell of height is granted to roughness. Cells without height hide nothing.
  [[nodiscard]] bool hides(double x, double y, double height_m, double camera_x, double camera_y,
                           double camera_height_m) const {
    return hides(occluders_m_, x, y, height_m, camera_x, camera_y, camera_height_m);
  }

  /// The same, but only what is more than 2 kThin cells wide both ways hides: not the twigs of a tree, nor single
  /// high cells.
  [[nodiscard]] bool hides_by_wide_things(double x, double y, double height_m, double camera_x, double camera_y,
                                          double camera_height_m) const {
    return hides(wide_m_, x, y, height_m, camera_x, camera_y, camera_height_m);
  }
  static constexpr int kThin = 2;

  /// The greatest height at which any cell no further than kCeilingReach cells from the place hides something, or more.
  [[nodiscard]] float ceiling_m(double x, double y) const;
  static constexpr int kCeilingReach = 16;

 private:
  [[nodiscard]] bool hides(const FloatImage& occluders_m, double x, double y, double height_m, double camera_x,
                           double camera_y, double camera_height_m) const;

  FloatImage heights_m_;
  FloatImage occluders_m_;  // no higher than the surface certainly is; minus infinity where nothing is
  FloatImage wide_m_;       // the lowest of these around
  FloatImage ceiling_m_;
  int column_ = 0, row_ = 0;
  double cell_m_ = 1;
  float highest_m_ = 0;
};

}  // namespace collinea
