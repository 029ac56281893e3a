// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/fitted_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace collinea {

Result<Camera> fitted_to(Camera camera, int width_px, int height_px, const std::string& image) {
  const double times = double(width_px) / camera.width_px;
  if (std::abs(times * camera.height_px - height_px) > std::max(1.0, times))
    return fail(Errc::kBadInput,
                fmt::format("the camera of {} takes images of {} x {} px, the photograph has {} x {} px", image,
                            camera.width_px, camera.height_px, width_px, height_px));
  scale_params(camera, times);
  camera.width_px = width_px;
  camera.height_px = height_px;
  return camera;
}

}  // namespace collinea
