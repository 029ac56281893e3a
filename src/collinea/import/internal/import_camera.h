// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/raster/image_file.h"

namespace collinea {

/// fx, fy, cx, cy and distortion of a camera of that model, from text. Errors: anything else, with what is expected.
[[nodiscard]] Result<std::vector<double>> camera_numbers(const std::string& text, CameraModel model);
/// One camera fits images of one size: focal length and principal point are in its pixels. Errors: images of another
/// size, a principal point outside.
[[nodiscard]] Result<> check_given_camera(const std::vector<double>& numbers, const Block& block);
[[nodiscard]] Camera given_camera(CameraModel model, const std::vector<double>& numbers, int width_px, int height_px);

/// By what the header says of the focal length; a usual one, as such (Provenance::kAssumed), where it says nothing or
/// what cannot be.
[[nodiscard]] Camera camera_from_header(const ImageHeader& header, CameraModel model);
[[nodiscard]] bool states_focal(const ImageHeader& header);
/// Maker, model, focal length and serial number, as far as they are stated.
[[nodiscard]] std::string camera_name(const ImageHeader& header);

}  // namespace collinea
