// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>

#include "collinea/image/geotiff.h"

namespace collinea {

/// A height at a place; NaN: nothing there.
struct HeightSample {
  double height_m = std::numeric_limits<double>::quiet_NaN(), sigma_m = height_m;
};

/// A raster of heights with one of their standard deviations, read as they are needed. Not for several threads at once.
class HeightSamples {
 public:
  /// Without a raster of sigmas all are `sigma_m`. Errors: files; two rasters that do not lie over each other.
  static Result<HeightSamples> open(const std::filesystem::path& height,
                                    const std::optional<std::filesystem::path>& sigma, double sigma_m);

  [[nodiscard]] const MapGrid& grid() const { return height_.grid(); }
  /// Windows, NaN where there is nothing.
  [[nodiscard]] Result<FloatImage> heights(int column, int row, int width, int height) const;
  [[nodiscard]] Result<FloatImage> sigmas(int column, int row, int width, int height) const;
  /// At a place of the map: bilinear between the middles of cells, that of the nearest cell in the outer half of the
  /// border's; nothing where one of the four cells has none. Places in order of rows are read fastest.
  Result<HeightSample> at(const Eigen::Vector2d& on_map);

 private:
  HeightSamples(GeoTiffReader height, std::optional<GeoTiffReader> sigma, double sigma_m)
      : height_(std::move(height)), sigma_(std::move(sigma)), sigma_m_(sigma_m) {}
  Result<> load(int row);

  GeoTiffReader height_;
  std::optional<GeoTiffReader> sigma_;
  double sigma_m_;
  int first_row_ = 0;
  FloatImage rows_, sigma_rows_;  // from first_row_ on
};

/// The rasters of standard deviations that lie beside one of heights, if they are there: dsm.tif and dsm_sigma.tif,
/// dsm_sigma_relative.tif.
[[nodiscard]] std::optional<std::filesystem::path> sigmas_beside(const std::filesystem::path& height);
[[nodiscard]] std::optional<std::filesystem::path> relative_sigmas_beside(const std::filesystem::path& height);

}  // namespace collinea
