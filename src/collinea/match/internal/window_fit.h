// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/match/internal/window_kernels.h"

namespace collinea {

/// Unknowns of a window in their order: position x, y, map xx, xy, yx, yy, gain, offset.
using ColumnMatrix = Eigen::Matrix<double, kWindowColumns, kWindowColumns>;
using ColumnVector = Eigen::Matrix<double, kWindowColumns, 1>;

/// Grey there = gain * T + offset.
struct WindowLightValues {
  double gain = 1, offset_grey = 0;
};

/// The window of a reference image, its pixels round a position, and what another image shows at its points: residuals
/// r = S(position + map u) - gain T(u) - offset, S and T smoothed by the cubic B-spline, T about its weighted mean.
/// B are the derivatives as the reference shows them, (Tx, Ty, u Tx, v Tx, u Ty, v Ty, -T, -1), A those of the other
/// image, (Sx, Sy, u Sx, v Sx, u Sy, v Sy, -T, -1), W the weights.
class WindowFit {
 public:
  /// Nothing when the window does not lie in the image. `gaussian`: weights of 0.6 of the half width, else 1.
  static std::optional<WindowFit> of(const GreyImage& image, const Eigen::Vector2d& position_px, int window_px,
                                     bool gaussian);

  /// Takes what `image` shows; false when a point lies less than two pixels inside.
  [[nodiscard]] bool sample(const GreyImage& image, const WindowPlacement& placement);
  /// Residuals of what was sampled; r'W r.
  double residuals(const WindowLightValues& light);

  [[nodiscard]] ColumnVector score();   ///< B'W r
  [[nodiscard]] ColumnMatrix matrix();  ///< B'W A
  /// B'W of other residuals of as many points, filled up to whole groups.
  [[nodiscard]] ColumnVector score_of(const float* residuals) { return products(residuals); }
  [[nodiscard]] const ColumnMatrix& normal() const { return normal_; }  ///< B'W B

  /// Covariance of B'W r for white noise of 1 in the pixels of both images, and the mean of r'W r were all unknowns
  /// known.
  struct Noise {
    ColumnMatrix covariance;
    double squares = 0;
  };
  [[nodiscard]] Noise noise(const WindowPlacement& placement, double gain) const;

  [[nodiscard]] double correlation() const;  ///< of S and T, weighted
  [[nodiscard]] double weights() const { return weights_; }
  [[nodiscard]] double template_square() const { return normal_(6, 6); }  ///< sum of w T^2
  [[nodiscard]] double mean_grey() const { return mean_; }                ///< of the reference, that T is about
  [[nodiscard]] int side() const { return side_; }
  [[nodiscard]] int count() const { return side_ * side_; }
  [[nodiscard]] const float* residual() const { return row(kResidual); }

  /// Multiplies the first weights by `factor`, one for each point.
  void reweight(const float* factor);

 private:
  enum Row : std::size_t {
    kU,
    kV,
    kFirstWeight,
    kWeight,
    kTemplate,
    kTemplateX,
    kTemplateY,
    kGrey,
    kX,
    kY,
    kResidual,
    kScratch,
    kColumns,
    kRows = kColumns + kWindowColumns
  };
  [[nodiscard]] float* row(std::size_t i) { return data_.data() + i * std::size_t(padded_); }
  [[nodiscard]] const float* row(std::size_t i) const { return data_.data() + i * std::size_t(padded_); }
  void weigh_columns();
  ColumnVector products(const float* values);
  ColumnVector products(const float* slope, const float* by);

  int side_ = 0, padded_ = 0;
  double weights_ = 0, mean_ = 0;
  std::vector<float> data_;  // rows of one float a point; columns of B are weighted
  ColumnMatrix normal_;
};

/// The variance of a pixel of the reference window after smoothing: (1/6, 4/6, 1/6) along both axes.
inline constexpr double kTemplateNoise = 0.25;

}  // namespace collinea
