// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

// What the files of PATB and BINGO have in common: image coordinates in a metric unit from the principal point, x right
// and y up, free of the lens's distortion, image by image, each list closed by -99; images and points are numbers.

struct PhotoPoint {
  std::string name;
  Eigen::Vector2d xy;  ///< [the unit of the file]
  std::size_t line = 0;
};

/// One image with its list.
struct PhotoList {
  std::string name;
  std::string camera;  ///< the second word of its head: of PATB the focal length, of BINGO the name of the camera
  std::size_t line = 0;
  std::vector<PhotoPoint> points;
};

/// Reads such lists. Empty lines count for nothing, but for one behind points: some programs write it in place of -99,
/// and what follows with a word that is no number in second place is then the head of an image. Lines that begin with #
/// or * are remarks. Errors name the line: no head, no coordinates, a point or an image that is there twice.
[[nodiscard]] Result<std::vector<PhotoList>> parse_photo_lists(std::string_view text);

/// A control or check point of such files.
struct PhotoControl {
  Eigen::Vector3d position;
  Eigen::Vector3d sigma_m;  ///< infinite: not given
  ControlRole role = ControlRole::kControl;
};

/// What we write beside such files, since they have no place for it: what their numbers stand for. Lines:
///     unit U               size of a pixel in the unit of the image coordinates
///     sigma S              standard deviation of an image coordinate, in that unit
///     image N FILE
///     control N ROLE SIGMA_E SIGMA_N SIGMA_H NAME
struct PhotoNames {
  double unit_per_px = 0;  ///< 0: not known
  double sigma = 0;        ///< 0: not known
  std::map<std::string, std::string> image, control;
  std::map<std::string, Eigen::Vector3d> sigma_m;
  std::map<std::string, ControlRole> role;
};

/// Errors name the line.
[[nodiscard]] Result<PhotoNames> parse_photo_names(std::string_view text);
/// That of the file, if it is there; errors name it.
[[nodiscard]] Result<PhotoNames> read_photo_names(const std::filesystem::path& path);

/// Where the lens's principal point and focal length are, in the unit of the file.
struct PhotoCamera {
  double focal = 0;
  Eigen::Vector2d principal{0, 0};
};

/// What holds where no names are there [the unit of the file].
struct PhotoDefaults {
  double unit_per_px = 1, sigma = 1;
};

/// All of it as an adjustment starts from it: the cameras without distortion and fixed, images without poses and as
/// large as their coordinates ask for. Error: no measurement at all.
[[nodiscard]] Result<AdjustmentFile> adjustment_of(const std::vector<PhotoList>& photos,
                                                   const std::map<std::string, PhotoCamera>& cameras,
                                                   const std::map<std::string, PhotoControl>& control,
                                                   const PhotoNames& names, const PhotoDefaults& defaults);

/// The numbers that a block's things get in such files: control from 1 on, then tie points; images their ids plus 1.
struct PhotoNumbers {
  std::map<ControlId, std::uint64_t> control;
  std::map<PointId, std::uint64_t> points;
  std::map<ImageId, std::uint64_t> images;
};
[[nodiscard]] PhotoNumbers numbers_of(const Block& block);

/// What the names file of a block says. `unit_per_px`: size of a pixel.
[[nodiscard]] std::string photo_names_text(const Block& block, const PhotoNumbers& numbers, double unit_per_px);

/// The image coordinates of a block, image by image, in the unit; behind the number of each image stands `head` of it.
/// Only oriented images and points that are measured in two of them and more are there, and all control.
[[nodiscard]] std::string photo_lists_text(const Block& block, const PhotoNumbers& numbers, double unit_per_px,
                                           int decimals, const std::map<CameraId, std::string>& head);

/// Control in the map, or in the world where the block has no georeference. Errors: a CRS that PROJ does not know.
[[nodiscard]] Result<std::map<std::uint64_t, PhotoControl>> control_of(const Block& block, const PhotoNumbers& numbers);

/// That such files have no place for fisheyes. Error: a camera that is one.
[[nodiscard]] Result<> check_photo_cameras(const Block& block, std::string_view format);

}  // namespace collinea
