// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// Writes the oriented images and the tie points in the format of Bundler (Snavely 2006): bundle.out (v0.3) and
/// list.txt with the file names, in the order of the ids. Bundler's camera frame is x right, y up, z backward; its
/// image coordinates count from the middle of the image, y up; its camera has one focal length and two radial terms
/// about that middle. What it cannot hold is taken into the observations: they are written as such a camera would have
/// measured them; the tie points are as they are. Returns what was changed so; none when nothing was.
/// Errors: a name that does not fit into a line (check_image_names), a fisheye.
[[nodiscard]] Result<std::vector<Finding>> write_bundler(const std::filesystem::path& folder, const Block& block);

/// An image's size in pixels: Bundler's files do not say it, but its coordinates count from the middle.
struct ImageSize {
  int width_px = 0, height_px = 0;
};

/// Reads bundle.out and list.txt of a folder. Every image has a camera
/// of its own. `size_of` tells the size of an image by its name in the list. Cameras with focal length 0 were not
/// oriented: their images are in the block, without pose. Errors name file and line.
[[nodiscard]] Result<Block> read_bundler(const std::filesystem::path& folder,
                                         const std::function<Result<ImageSize>(const std::string&)>& size_of);

}  // namespace collinea
