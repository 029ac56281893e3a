// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// What the header of an image says (EXIF, XMP of drones); only what is really there. By Exiv2.
struct ImageHeader {
  int width_px = 0, height_px = 0;
  std::string maker, model, serial, lens;
  std::optional<double> focal_mm, focal_35mm_mm;
  std::optional<double> pixel_pitch_mm;  ///< from FocalPlaneXResolution and its unit, when plausible
  std::string taken;                     ///< "YYYY:MM:DD hh:mm:ss.sss"
  int orientation = 1;
  std::optional<double> latitude_deg, longitude_deg, height_m;  ///< GPS; XMP's finer values where they agree
  std::optional<double> sigma_east_m, sigma_north_m,
      sigma_height_m;                       ///< XMP RTK (drone-dji:RtkStdLon/Lat/Hgt), GPSHPositioningError
  std::optional<double> relative_height_m;  ///< above take-off (drone-dji:RelativeAltitude)
  std::optional<double> heading_deg, pitch_deg, roll_deg;  ///< gimbal (drone-dji:Gimbal*Degree, Camera:*)
};

/// Whether a file is one of those that are read here, by the end of its name (.jpg, .jpeg, .png, .tif, .tiff; in any
/// letter case).
[[nodiscard]] bool is_image_name(const std::filesystem::path& path);

/// Reads the header. Errors: not an image we know (JPEG, PNG, TIFF), cannot be opened. Broken EXIF is no error:
/// the fields stay empty.
[[nodiscard]] Result<ImageHeader> read_image_header(const std::filesystem::path& path);

/// Decodes an image to 8-bit colour (3 channels) or grey (1 channel; JPEG decoded straight to its luma).
/// 16-bit files are scaled by their own 0.1 and 99.9 percentiles. `shrink` = 1, 2, 4 or 8 decodes at a reduced size
/// (ceil(size / shrink); in the JPEG decoder where it can). EXIF orientation is not applied.
/// Errors: missing, not an image, truncated or damaged data (a JPEG that ends early is an error, not a grey bottom).
[[nodiscard]] Result<ColourImage> read_colour(const std::filesystem::path& path, int shrink = 1);
[[nodiscard]] Result<GreyImage> read_grey(const std::filesystem::path& path, int shrink = 1);

/// Which pixels the file has, 255, and which it states as empty, 0: by its alpha channel (0), its mask, or the no-data
/// value of all its bands. Nothing when all are there. Errors: missing, not an image.
[[nodiscard]] Result<std::optional<GreyImage>> read_known_pixels(const std::filesystem::path& path);

/// 1 when the file holds nothing but grey values, else 3. Errors: missing, not an image.
[[nodiscard]] Result<int> channels_of(const std::filesystem::path& path);

/// Writes 8-bit images (1 or 3 channels), atomically. With a header, JPEG gets its EXIF and XMP tags.
[[nodiscard]] Result<> write_jpeg(const std::filesystem::path& path, const Raster<std::uint8_t>& image, int quality,
                                  const ImageHeader* header = nullptr);
[[nodiscard]] Result<> write_png(const std::filesystem::path& path,
                                 const Raster<std::uint8_t>& image);  ///< 1, 3 or 4 channels
/// The same, into memory: for images inside a report.
[[nodiscard]] Result<std::string> encode_jpeg(const Raster<std::uint8_t>& image, int quality);

}  // namespace collinea
