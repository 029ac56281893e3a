// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "collinea/raster/geotiff.h"

namespace collinea {

/// Heights on disk with their standard deviations.
struct SurfaceFiles {
  std::filesystem::path height;
  std::optional<std::filesystem::path> sigma = {};
  /// The part of sigma that neighbours do not have in common; nothing: all of it. What is beyond lifts an area as a
  /// whole.
  std::optional<std::filesystem::path> sigma_relative = {};
};

/// A raster of heights and those of standard deviations that lie beside it, if they are there: dsm.tif, dsm_sigma.tif
/// and dsm_sigma_relative.tif (which says nothing without dsm_sigma.tif).
[[nodiscard]] SurfaceFiles with_sigmas_beside(const std::filesystem::path& height);

/// A height at a position; NaN: nothing there.
struct HeightSample {
  double height_m = std::numeric_limits<double>::quiet_NaN(), sigma_m = height_m, sigma_relative_m = height_m;
};

/// A raster of heights with those of their standard deviations, read as they are needed. Not for several threads at
/// once.
class HeightSamples {
 public:
  /// Without a raster of sigmas all are `sigma_m`, and relative. Errors: files; rasters that do not lie over each
  /// other; relative sigmas alone.
  static Result<HeightSamples> open(const SurfaceFiles& files, double sigma_m);

  [[nodiscard]] const MapGrid& grid() const { return height_.grid(); }
  /// Windows, NaN where there is nothing.
  [[nodiscard]] Result<FloatImage> heights(int column, int row, int width, int height) const;
  [[nodiscard]] Result<FloatImage> sigmas(int column, int row, int width, int height) const;
  [[nodiscard]] Result<FloatImage> relative_sigmas(int column, int row, int width, int height) const;
  /// At a point of the map: bilinear between the middles of cells, that of the nearest cell in the outer half of the
  /// border's; nothing where one of the four cells has none. Positions in order of rows are read fastest.
  Result<HeightSample> at(const Eigen::Vector2d& on_map);

 private:
  HeightSamples(GeoTiffReader height, double sigma_m) : height_(std::move(height)), sigma_m_(sigma_m) {}
  Result<> load(int row);

  GeoTiffReader height_;
  std::optional<GeoTiffReader> sigma_, sigma_relative_;
  double sigma_m_;
  int first_row_ = 0;
  FloatImage rows_, sigma_rows_, relative_rows_;  // from first_row_ on
};

}  // namespace collinea
