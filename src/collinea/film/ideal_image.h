// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/camera/film_calibration.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// The image of a film camera as a camera without distortion would have taken it, on film that did not shrink: what
/// scans are resampled to, once, so that all that follows knows one camera and no film.
struct IdealImage {
  FilmCalibration calibration;
  double pixel_mm = 0;
  Camera camera;  ///< given, not to be calibrated

  /// Where it shows what lies at a position on the film, and the other way round. Any position.
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector2d& film_mm) const;
  [[nodiscard]] Eigen::Vector2d film_of(const Eigen::Vector2d& pixel) const;
};

/// Of the image area of the calibration (film_image_size()), without frame and marks.
[[nodiscard]] IdealImage ideal_image(const FilmCalibration& calibration, double pixel_mm);

/// The scan (1 or 3 channels) resampled by cubic convolution. The way from pixel to pixel is exact on a lattice of 32
/// px and linear between. 0 where the scan has nothing, else 1 to 255. The same bits for any number of threads. Memory:
/// scan and image.
[[nodiscard]] Raster<std::uint8_t> resampled_scan(const Raster<std::uint8_t>& scan,
                                                  const FilmTransformation& scan_from_film, const IdealImage& ideal,
                                                  const Run& run);

/// Reads the scan, in colour where it is, resamples it and writes it as JPEG of the finest quality. Memory: the scan.
/// Errors: files; cancelled.
[[nodiscard]] Result<> write_ideal_image(const std::filesystem::path& scan, const FilmTransformation& scan_from_film,
                                         const IdealImage& ideal, const std::filesystem::path& out, const Run& run);

/// The file name of the ideal image of a scan: the same, of a JPEG file.
[[nodiscard]] std::string ideal_image_name(const std::string& scan);

}  // namespace collinea
