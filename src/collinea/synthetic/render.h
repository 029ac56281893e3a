// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/raster/raster.h"
#include "collinea/synthetic/internal/truth.h"

namespace collinea {

/// Where every pixel of a camera looks: (X/Z, Y/Z) of its centre, computed once for all images of the camera.
class RayTable {
 public:
  RayTable(const Camera& camera, const Run& run);

  [[nodiscard]] const Camera& camera() const { return camera_; }
  /// The direction (x, y, 1) in the camera frame of a position `dx`, `dy` [px] off the centre of pixel (column, row),
  /// both offsets within half a pixel. Good to 1e-4 px.
  [[nodiscard]] Eigen::Vector3d direction(int column, int row, double dx = 0, double dy = 0) const;

 private:
  Camera camera_;
  std::vector<float> directions_;
};

/// The image: for every pixel a ray through the exact camera, shaded; edges of objects and shadows supersampled;
/// then blur, vignetting, exposure, tone curve, noise. The same whatever run.threads is. Memory: 16 bytes a pixel.
/// Error: stopped.
[[nodiscard]] Result<ColourImage> render(const Truth& truth, ImageId image, const RayTable& rays, const Run& run);

/// The grey level that the cameras write for an amount of light (gamma 2.2), before rounding: [0, 255].
[[nodiscard]] float tone(float light);

}  // namespace collinea
