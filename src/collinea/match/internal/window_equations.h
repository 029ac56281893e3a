// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/match/internal/spline_window.h"

namespace collinea {

/// The window of the reference image: its pixels round the point, smoothed by the spline.
struct ReferenceTemplate {
  struct Point {
    SplineSample sample;
    Eigen::Vector2d offset;  ///< from the point [px of the reference]
    double weight = 0;
  };
  std::vector<Point> points;
  double weights = 0;
  int left = 0, top = 0, side = 0;  ///< of all pixels that take part

  /// Grey values are about their weighted mean. Nothing when the window does not lie in the image.
  static std::optional<ReferenceTemplate> of(const GreyImage& image, const Eigen::Vector2d& at, int window_px);
};

/// Where the window lies in another image, and its light there.
struct WindowState {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d map;
  double gain = 1, offset_grey = 0;
  std::vector<Eigen::Vector2d> bend;  ///< of each point, what perspective adds to the map [px]; empty: nothing

  [[nodiscard]] Eigen::Vector2d position(const ReferenceTemplate& reference, std::size_t point) const {
    const Eigen::Vector2d at = pixel + map * reference.points[point].offset;
    return bend.empty() ? at : Eigen::Vector2d(at + bend[point]);
  }
};

inline constexpr int kWindowUnknowns = 8;  // shift of the pixel, affine map, gain, offset
using WindowVector = Eigen::Matrix<double, kWindowUnknowns, 1>;
using WindowMatrix = Eigen::Matrix<double, kWindowUnknowns, kWindowUnknowns>;

/// The equations of one window: with r = S(pixel + map u) - gain T(u) - offset and their derivatives A by the unknowns
/// x the changes obey  Z'W A x = -Z'W r.  Z are the derivatives as the reference shows them: their noise and that of
/// the slopes in A are not the same, so that no square of noise enters Z'W A (instrumental variables).
struct WindowEquations {
  WindowMatrix matrix;  ///< Z'W A
  WindowVector right;   ///< -Z'W r
  double squares = 0;   ///< r'W r
  double white = 0;     ///< what r'W r would be on an average for noise of 1 grey and known unknowns
  double correlation = 0;
  std::vector<WindowVector> by_point;  ///< columns of Z'W
  std::vector<SplineSample> samples;   ///< of S
};
/// What is known of the affine map beforehand, and the weight of its elements against the square of a grey value.
struct MapPrior {
  Eigen::Matrix2d map;
  double weight = 0;
};
/// Nothing when the window does not lie in the image.
[[nodiscard]] std::optional<WindowEquations> window_equations(const ReferenceTemplate& reference,
                                                              const GreyImage& image, const WindowState& state,
                                                              const MapPrior& prior);

/// Means of r over blocks of 3 x 3 points: what they are, and what they would be for white noise of 1 in the pixels.
struct BlockMeans {
  static constexpr int kSide = 3;
  double squares = 0, white = 0;  ///< weighted
};
[[nodiscard]] BlockMeans block_means(const ReferenceTemplate& reference, const WindowEquations& equations,
                                     const WindowState& state);

/// The weighted correlation of the window with the reference, at every `step`-th point of every `step`-th row. Nothing
/// outside the image; 0 without texture.
[[nodiscard]] std::optional<double> window_correlation(const ReferenceTemplate& reference, const GreyImage& image,
                                                       const Eigen::Vector2d& pixel, const Eigen::Matrix2d& map,
                                                       int step);

/// Linear forms of the grey values of pixels, one vector of coefficients a pixel: what their noise does to `size`
/// quantities.
template <int N>
struct PixelForms {
  int left = 0, top = 0, width = 0, height = 0;
  std::vector<Eigen::Matrix<double, N, 1>> at;

  void add(const SplineSample& sample, const Eigen::Matrix<double, N, 1>& coefficient) {
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        const std::size_t pixel =
            std::size_t(sample.top + j - top) * std::size_t(width) + std::size_t(sample.left + i - left);
        at[pixel] += (sample.across[std::size_t(i)] * sample.down[std::size_t(j)]) * coefficient;
      }
  }
  /// The covariance of the quantities of two forms of the same pixels, for white noise of 1.
  [[nodiscard]] Eigen::Matrix<double, N, N> with(const PixelForms& other) const {
    Eigen::Matrix<double, N, N> sum = Eigen::Matrix<double, N, N>::Zero();
    for (std::size_t i = 0; i < at.size(); ++i) sum.noalias() += at[i] * other.at[i].transpose();
    return sum;
  }
};

/// transform * Z'W r as forms of the pixels of the image, and of those of the reference.
template <int N>
[[nodiscard]] PixelForms<N> forms_of_image(const WindowEquations& equations,
                                           const Eigen::Matrix<double, N, kWindowUnknowns>& transform) {
  PixelForms<N> forms;
  int right = 0, bottom = 0;
  forms.left = forms.top = 1 << 30;
  for (const SplineSample& sample : equations.samples) {
    forms.left = std::min(forms.left, sample.left);
    forms.top = std::min(forms.top, sample.top);
    right = std::max(right, sample.left + 4);
    bottom = std::max(bottom, sample.top + 4);
  }
  forms.width = right - forms.left;
  forms.height = bottom - forms.top;
  forms.at.assign(std::size_t(forms.width) * std::size_t(forms.height), Eigen::Matrix<double, N, 1>::Zero());
  for (std::size_t k = 0; k < equations.samples.size(); ++k)
    forms.add(equations.samples[k], transform * equations.by_point[k]);
  return forms;
}
template <int N>
[[nodiscard]] PixelForms<N> forms_of_reference(const ReferenceTemplate& reference, const WindowEquations& equations,
                                               double gain,
                                               const Eigen::Matrix<double, N, kWindowUnknowns>& transform) {
  PixelForms<N> forms;
  forms.left = reference.left;
  forms.top = reference.top;
  forms.width = forms.height = reference.side;
  forms.at.assign(std::size_t(forms.width) * std::size_t(forms.height), Eigen::Matrix<double, N, 1>::Zero());
  for (std::size_t k = 0; k < equations.samples.size(); ++k)
    forms.add(reference.points[k].sample, -gain * (transform * equations.by_point[k]));
  return forms;
}

}  // namespace collinea
