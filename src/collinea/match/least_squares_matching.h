// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "collinea/match/internal/least_squares_kernels.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A square of an image, or of a level of its pyramid, kept while the image itself is let go.
struct Patch {
  static constexpr int kSize = 48;  ///< pixels a side: the window, turned and stretched, and room to move

  std::array<std::uint8_t, kSize * kSize + 4> grey{};
  Eigen::Vector2d corner_px = Eigen::Vector2d::Zero();  ///< outer corner of the first pixel, in the image
  double pixel_px = 1;                                  ///< size of a pixel of the level, in pixels of the image
};

/// The square round a position in the image, moved inwards at its border. Nothing when the level is smaller.
[[nodiscard]] std::optional<Patch> cut_patch(const GreyImage& level, double pixel_px,
                                             const Eigen::Vector2d& position_px);

/// Where a window lies in another image: a point `offset` [px] from the middle of the reference is seen at
/// position_px + warp * offset.
struct Placement {
  Eigen::Vector2d position_px;
  Eigen::Matrix2d warp;
};

/// What perspective and lens add to the affine map of a window: an offset (x, y) [px] of the reference is seen where
/// the map has (x, y) + by_squares (x x, x y, y y).
struct WindowBend {
  Eigen::Matrix<double, 2, 3> by_squares = Eigen::Matrix<double, 2, 3>::Zero();  ///< [1/px]
};

struct LeastSquaresMatch {
  Placement placement;
  double correlation = 0;   ///< of the grey values
  double gain = 1;          ///< of the other image against the reference
  double squares_left = 0;  ///< weighted sum of squared residuals, in grey values of the reference
};

/// The covariance of a position found, for white noise of equal size in the pixels of both images, as the residuals
/// show it: what interpolation makes of it is followed exactly, and what noise adds to the squares of the slopes is
/// taken off. The noise of the reference is that of one position there, the same for all other images.
struct MatchCovariance {
  Eigen::Matrix2d of_other_px2;      ///< by the noise of the other image
  Eigen::Matrix2d of_reference_px2;  ///< by that of the reference, in its pixels
  Eigen::Matrix2d warp;

  /// Of the position in the other image, relative to the reference.
  [[nodiscard]] Eigen::Matrix2d relative_px2() const {
    return of_other_px2 + warp * of_reference_px2 * warp.transpose();
  }
};

/// A window of a reference image that is looked for in others by least squares matching (Ackermann 1984; Gruen 1985):
/// position, affine map, gain and offset such that grey values differ least. The window has kWindow x kWindow points,
/// weighted by a Gaussian of 0.6 of its half width. The derivatives are those of the reference (inverse composition,
/// Baker and Matthews 2004): they and their normal equations are set up once for all other images.
class ReferenceWindow {
 public:
  /// The points are the pixels of the patch round the position. Nothing where the window does not lie in the patch or
  /// its texture does not fix a position in both directions (constant, or a straight edge).
  static std::optional<ReferenceWindow> of(const Patch& patch, const Eigen::Vector2d& position_px);

  /// The window in another image, from a position good to a few pixels of the reference's patch. Nothing when this does
  /// not converge, leaves the patch, moves by more than farthest_px or changes the map by more than a half, correlates
  /// by less than 0.8, or when the standard deviation of the position is more than a quarter of such a pixel.
  [[nodiscard]] std::optional<LeastSquaresMatch> find(const Patch& other, const Placement& start, double farthest_px,
                                                      const WindowBend& bend = {}) const;

  /// How well the position found is known. Costs about as much as finding it. Nothing where noise is all there is.
  [[nodiscard]] std::optional<MatchCovariance> covariance(const Patch& other, const LeastSquaresMatch& match,
                                                          const WindowBend& bend = {}) const;

  /// Half the side of the window.
  [[nodiscard]] double reach_px() const { return kWindow / 2.0 * spacing_px_; }

 private:
  using Values = std::array<float, kWindowFloats>;
  struct BentPoints {
    Values u, v;
  };
  [[nodiscard]] BentPoints bent(const WindowBend& bend) const;
  using Matrix8d = Eigen::Matrix<double, kUnknowns, kUnknowns>;

  double spacing_px_ = 1;                                    // between neighbouring points
  Eigen::Vector2d position_;                                 // from the window's middle, in spacings
  Values grey_{};                                            // minus its mean
  double grey_square_ = 0;                                   // weighted mean
  std::array<float, kUnknowns * kWindowFloats> weighted_{};  // derivatives by position, map, gain and offset, by weight
  Matrix8d normal_, inverse_;                                // J'W J, and its inverse
  Matrix8d twice_weighted_;                                  // J'W W J
  Eigen::Matrix2d cofactor_;                                 // of the position, for equally good grey values
  double redundancy_ = 0;                                    // in weights
};

}  // namespace collinea
