// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

enum class ColmapEncoding { kText, kBinary };

/// Writes the oriented images, their cameras and the tie points as a COLMAP model (cameras, images, points3D as .txt or
/// .bin) in the block's world frame. Cameras become FULL_OPENCV, a fisheye OPENCV_FISHEYE (THIN_PRISM_FISHEYE with
/// decentring); OpenCV's p1, p2 are our p2, p1, and f, b1 become fx = f + b1, fy = f. Both sides count pixels alike.
/// Ids are ours plus one: COLMAP's start at 1. Returns what COLMAP cannot hold (the shear b2, additional
/// parameters, the equisolid projection); none when nothing was lost. Errors: brown_of_measured, a name that
/// does not fit into a line (check_image_names).
[[nodiscard]] Result<std::vector<Finding>> write_colmap(const std::filesystem::path& folder, const Block& block,
                                                        ColmapEncoding encoding);

/// Reads a COLMAP model, binary if there is one, else text. Models SIMPLE_PINHOLE, PINHOLE, SIMPLE_RADIAL, RADIAL,
/// OPENCV, FULL_OPENCV without denominator, SIMPLE_RADIAL_FISHEYE, RADIAL_FISHEYE, OPENCV_FISHEYE, THIN_PRISM_FISHEYE
/// as far as it has a counterpart. Ids are COLMAP's less one (unless some id is 0: then as they are); the
/// feature of an observation is its index in COLMAP's list. Without points3D there are only cameras and poses. Errors:
/// files missing or damaged, other camera models.
[[nodiscard]] Result<Block> read_colmap(const std::filesystem::path& folder);

/// The cameras of a file cameras.txt of COLMAP alone, by their ids: a line each, ID MODEL WIDTH HEIGHT PARAMS. Models
/// as read_colmap(). Errors: missing, damaged, no camera, other models.
[[nodiscard]] Result<std::vector<Camera>> read_colmap_cameras(const std::filesystem::path& file);

}  // namespace collinea
