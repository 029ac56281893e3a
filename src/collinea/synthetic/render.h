// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/math/random.h"
#include "collinea/raster/raster.h"
#include "collinea/synthetic/internal/truth.h"

namespace collinea {

/// Where the pixels of an image look.
class PixelRays {
 public:
  virtual ~PixelRays() = default;
  /// A direction in the camera frame with positive z, of a position `dx`, `dy` [px] off the centre of pixel (column,
  /// row), both offsets within half a pixel. Zero: the image shows nothing there.
  [[nodiscard]] virtual Eigen::Vector3d direction(int column, int row, double dx, double dy) const = 0;
  [[nodiscard]] virtual double focal_px() const = 0;
};

/// Where every pixel of a camera looks: (X/Z, Y/Z) of its centre, computed once for all images of the camera. Good to
/// 1e-4 px.
class RayTable final : public PixelRays {
 public:
  RayTable(const Camera& camera, const Run& run);

  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] Eigen::Vector3d direction(int column, int row, double dx = 0, double dy = 0) const override;
  [[nodiscard]] double focal_px() const override { return camera_.focal_px(); }

 private:
  Camera camera_;
  std::vector<float> directions_;
};

/// Rows of an image from `first` on.
struct RowRange {
  int first = 0, count = 0;
};

/// The light that reaches these rows before lens and film blur it; edges of objects and shadows supersampled (but for
/// those between a border row and its neighbour outside of the range). The same whatever run.threads is.
[[nodiscard]] Raster<Colour> exposed_light(const Truth& truth, ImageId image, const PixelRays& rays, int width,
                                           RowRange rows, const Run& run);

/// Weights of a Gaussian from -3 to 3 standard deviations; one weight for 0.
[[nodiscard]] std::vector<float> gaussian_weights(double sigma_px);

/// One row of the light, blurred along rows and columns; beyond the border the border pixel goes on. `vertical`:
/// scratch.
void blur_row(const Raster<Colour>& light, int row, const std::vector<float>& weights, std::vector<Colour>& vertical,
              std::vector<Colour>& out);

/// Close to normal, standard deviation 1: the sum of the four 16-bit parts of one draw.
[[nodiscard]] float quick_normal(Random& random);

/// The image: for every pixel a ray through the exact camera, shaded; edges of objects and shadows supersampled;
/// then blur, vignetting, exposure, tone curve, noise. The same whatever run.threads is. Memory: 16 bytes a pixel.
/// Error: stopped.
[[nodiscard]] Result<ColourImage> render(const Truth& truth, ImageId image, const RayTable& rays, const Run& run);

/// The grey level that the cameras write for an amount of light (gamma 2.2), before rounding: [0, 255].
[[nodiscard]] float tone(float light);

}  // namespace collinea
