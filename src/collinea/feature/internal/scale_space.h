// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <vector>

#include "collinea/feature/internal/sift_kernels.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A float image whose rows may be read and written a little beyond their end (kRowSlack). Move only: planes are
/// large.
class Plane {
 public:
  Plane() = default;
  Plane(int width, int height);  ///< pixels are not set

  [[nodiscard]] int width() const { return width_; }
  [[nodiscard]] int height() const { return height_; }
  [[nodiscard]] float* row(int y) { return data_.get() + y * stride_; }
  [[nodiscard]] const float* row(int y) const { return data_.get() + y * stride_; }
  [[nodiscard]] float at(int x, int y) const { return row(y)[x]; }
  [[nodiscard]] bool empty() const { return !data_; }
  [[nodiscard]] BlurredImage view() const { return {data_.get(), stride_, width_, height_}; }

 private:
  int width_ = 0, height_ = 0;
  std::ptrdiff_t stride_ = 0;
  struct Free {
    void operator()(float* data) const;
  };
  std::unique_ptr<float[], Free> data_;
};

/// Levels of blur in one octave of Lowe (2004): three whole steps, and what the differences at their two ends need.
inline constexpr int kSteps = 3;
inline constexpr int kLevels = kSteps + 3;
inline constexpr double kFirstBlur_px = 1.6;  ///< of level 0, in pixels of the octave

/// The blur of a level, which may lie between two [pixels of the octave].
[[nodiscard]] double blur_of_level(double level);

using Octave = std::array<Plane, kLevels>;

/// Convolves with a Gaussian; the border pixels are repeated outwards.
[[nodiscard]] Plane blurred(const Plane& in, double sigma_px);

/// Level 0 of the first octave: the image as floats [0, 255], at twice its size if so wished, blurred to
/// kFirstBlur_px. An image is taken to be blurred by the area of its pixels alone. Where its pixel centre (x, y),
/// counted from 0, lies in the image: (x + 0.5) * (upsample ? 0.5 : 1), likewise y.
[[nodiscard]] Plane first_level(const GreyImage& image, bool upsample);

/// All levels of an octave from its level 0.
[[nodiscard]] Octave octave_from(Plane level0);

/// Level 0 of the next octave: every second pixel of every second row, from the first on, of level kSteps.
[[nodiscard]] Plane next_level0(const Octave& octave);

}  // namespace collinea
