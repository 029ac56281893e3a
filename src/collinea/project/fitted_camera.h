// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// A camera as of images of another size: a model may have been made on copies of them. `image` is named in the
/// error: the proportions of the images differ by more than a pixel.
[[nodiscard]] Result<Camera> fitted_to(Camera camera, int width_px, int height_px, const std::string& image);

}  // namespace collinea
