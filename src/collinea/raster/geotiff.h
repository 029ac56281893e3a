// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Where the cells of a north-up raster lie on the map: the outer corner of the upper-left cell and the cell size.
struct MapGrid {
  double west_m = 0, north_m = 0;  ///< outer corner of the upper-left cell
  double cell_m = 1;
  int width = 0, height = 0;  ///< cells
  std::string wkt;            ///< of the CRS; empty: a local frame

  // Columns and rows are continuous: 0 is the outer edge of the first, 0.5 its middle.
  [[nodiscard]] double east_of(double column) const { return west_m + column * cell_m; }
  [[nodiscard]] double north_of(double row) const { return north_m - row * cell_m; }
  [[nodiscard]] double column_of(double east_m) const { return (east_m - west_m) / cell_m; }
  [[nodiscard]] double row_of(double at_north_m) const { return (north_m - at_north_m) / cell_m; }
};

/// Whether cells of two rasters lie at the same positions, up to the rounding of decimal numbers in files: a thousandth
/// of a cell. The CRS is not looked at.
[[nodiscard]] bool same_cells(const MapGrid& a, const MapGrid& b);

/// Smaller copies of a raster inside its file, each half as large as the one before, down to some 512 cells: viewers
/// read what they show. Of values the mean of those that there are; of numbers that stand for something the nearest.
enum class Overviews { kNone, kMean, kNearest };

/// Writes a raster on disk block by block (tiled GeoTIFF, DEFLATE, floating-point or byte samples); the file appears
/// under its name only after finish(). By GDAL.
template <class T>
class GeoTiffWriter {
 public:
  /// `channels` bands; nodata as stated; with `alpha` the last band is an alpha band. cloud_optimised: written as COG
  /// with overviews.
  struct Options {
    std::optional<double> nodata = {};
    bool alpha = false;
    bool cloud_optimised = false;
    Overviews overviews = Overviews::kNone;  ///< of rasters that are not cloud-optimised
    std::string description = {};            ///< TIFF ImageDescription: what and in which unit
    int threads = 1;                         ///< that compress a cloud-optimised file; its bytes do not depend on it
  };
  static Result<GeoTiffWriter> create(const std::filesystem::path& path, const MapGrid& grid, int channels,
                                      const Options& options);
  /// Writes a window inside the grid. Not thread-safe. Windows on multiples of 512 cells (or ending at the grid's edge)
  /// are written at once; the same ones in the same order make the same bytes. Others work, but slower and larger.
  Result<> write(int column, int row, const Raster<T>& window);
  Result<> finish();

  GeoTiffWriter(GeoTiffWriter&&) noexcept;
  GeoTiffWriter& operator=(GeoTiffWriter&&) noexcept;
  ~GeoTiffWriter();

 private:
  GeoTiffWriter();
  struct State;
  std::unique_ptr<State> state_;
};
extern template class GeoTiffWriter<float>;
extern template class GeoTiffWriter<std::uint8_t>;
extern template class GeoTiffWriter<std::uint16_t>;

/// A GeoTIFF opened for reading by windows. Not thread-safe. What is resampled comes from the cells themselves, of
/// bytes (pictures) from overviews where the file has them. A file without georeference has cells of 1 and its
/// lower-left corner at (0, 0).
class GeoTiffReader {
 public:
  static Result<GeoTiffReader> open(const std::filesystem::path& path);
  [[nodiscard]] const MapGrid& grid() const;
  [[nodiscard]] int channels() const;
  [[nodiscard]] std::optional<double> nodata() const;
  /// Reads a window of all channels, converted to T, optionally resampled (average, nodata left out) to out_width x
  /// out_height. Errors: a window outside the raster, damaged data.
  Result<Raster<float>> read_float(int column, int row, int width, int height, int out_width = 0,
                                   int out_height = 0) const;
  /// As read_float, with NaN in place of nodata.
  Result<Raster<float>> read_known(int column, int row, int width, int height, int out_width = 0,
                                   int out_height = 0) const;
  Result<Raster<std::uint8_t>> read_byte(int column, int row, int width, int height, int out_width = 0,
                                         int out_height = 0) const;

  GeoTiffReader(GeoTiffReader&&) noexcept;
  GeoTiffReader& operator=(GeoTiffReader&&) noexcept;
  ~GeoTiffReader();

 private:
  GeoTiffReader();
  struct State;
  std::unique_ptr<State> state_;
};

/// A float raster without georeference (depth maps), any channels, compressed losslessly in strips, written atomically;
/// and back. From several threads at once on different files.
[[nodiscard]] Result<> write_float_tiff(const std::filesystem::path& path, const FloatImage& raster);
[[nodiscard]] Result<FloatImage> read_float_tiff(const std::filesystem::path& path);

}  // namespace collinea
