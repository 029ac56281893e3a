// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
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
  [[nodiscard]] std::ptrdiff_t stride() const { return stride_; }  ///< floats from row to row
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

/// Writes row y of an image; asked for all rows in order, upper first.
using RowSource = std::function<void(int y, float* row)>;

/// Convolves an image with a Gaussian, row by row: only the rows within its reach are held. The border pixels are
/// repeated outwards.
class RowFilter {
 public:
  RowFilter(int width, int height, double sigma_px);

  [[nodiscard]] int radius() const { return radius_; }
  /// Writes the next row; the source is asked for rows up to radius() below it.
  void next(const RowSource& source, float* out);

 private:
  void fill(const RowSource& source);

  std::vector<float> taps_;
  int radius_, width_, height_;
  int filled_ = 0, next_ = 0;  // rows of the source that are in, and that are filtered
  Plane ring_;
  std::vector<float> padded_;
  std::vector<const float*> rows_;
};

/// Convolves with a Gaussian; the border pixels are repeated outwards.
[[nodiscard]] Plane blurred(const Plane& in, double sigma_px);

/// Level 0 of the first octave: the image as floats [0, 255], at twice its size if so wished, blurred to
/// kFirstBlur_px. An image is taken to be blurred by the area of its pixels alone. Where its pixel centre (x, y),
/// counted from 0, lies in the image: (x + 0.5) * (upsample ? 0.5 : 1), likewise y.
[[nodiscard]] Plane first_level(const GreyImage& image, bool upsample);

/// The same, row by row. The image must outlive it.
[[nodiscard]] RowSource first_level_rows(const GreyImage& image, bool upsample);

}  // namespace collinea
