// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/raster/geotiff.h"

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

/// The same surface held unpacked on disk (RasterSpool) beside a file, for a field that is read again and again.
/// Errors: `field` cannot be read, nothing be written there; cancelled. A full disk is reported by the first read.
[[nodiscard]] Result<HeightField> unpacked(const HeightField& field, const std::filesystem::path& beside,
                                           const Run& run);

/// Cells of a grid; may reach beyond it.
struct CellArea {
  int column, row, width, height;
};

/// A point of the surface, in continuous cells of its raster.
struct SurfaceSample {
  double column = 0, row = 0;
  float height_m = 0;
};

/// The surface in blocks of kBlock x kBlock cells: between which heights it lies.
struct HeightOverview {
  static constexpr int kBlock = 32;
  FloatImage lowest_m, highest_m;      ///< per block; NaN where no cell has a height
  std::vector<SurfaceSample> samples;  ///< the cell nearest to the middle of each block, block by block
  double mean_m = 0;                   ///< of the samples
};
[[nodiscard]] Result<HeightOverview> overview(const HeightField& field, const Run& run);

/// The height at a position of a window of the surface (continuous cells: the centre of its upper-left cell is (0.5,
/// 0.5)): bilinear on a smooth surface, of the nearest cell beside steps and holes (a slope between roof and ground
/// would be painted with colours that belong to neither). NaN where the position has no height.
[[nodiscard]] float height_at(const FloatImage& heights_m, double x, double y, double cell_m);

}  // namespace collinea
