// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/feature/edge_map.h"
#include "collinea/feature/ellipse.h"
#include "collinea/raster/raster.h"

// Targets measured by least squares of grey values: a model of the target, blurred, is fitted to all pixels of a
// window. With white noise the residuals are independent, so that the covariance of the centre is that of the errors.
namespace collinea {

enum class TargetKind : std::uint8_t { kCircle, kCross, kChequerboard };
inline constexpr Word<TargetKind> kTargetKindWords[] = {
    {TargetKind::kCircle, "circle", "a disc, brighter or darker than what is around; an ellipse in the image"},
    {TargetKind::kCross, "cross", "two bars that cross"},
    {TargetKind::kChequerboard, "chequerboard", "the corner where two dark and two bright fields meet"}};
[[nodiscard]] constexpr std::span<const Word<TargetKind>> words(TargetKind) { return kTargetKindWords; }

/// The unknowns of a target, in the order in which they are adjusted. Lengths in px, angles in rad, grey values.
///     circle:        x, y, blur, ground, slope x, slope y, contrast, major, minor, angle
///     cross:         x, y, blur, ground, slope x, slope y, contrast, angle 1, angle 2, half width 1, half width 2
///     chequerboard:  x, y, blur, ground, slope x, slope y, contrast, angle 1, angle 2
/// The grey value is ground + slope . (p - centre) + contrast * shape(p), the shape going from 0 to 1 (-1 to 1 of a
/// chequerboard), with borders blurred by a Gaussian.
using TargetUnknowns = Eigen::VectorXd;
/// The grey value at a pixel and, where wanted, its derivatives after the unknowns.
[[nodiscard]] double target_grey(TargetKind kind, const TargetUnknowns& unknowns, const Eigen::Vector2d& p,
                                 Eigen::VectorXd* derivatives = nullptr);

struct Target {
  TargetKind kind = TargetKind::kCircle;
  Eigen::Vector2d at = {};                               ///< its centre [px]; of a circle, that of its ellipse
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the centre [px^2]
  TargetUnknowns unknowns;
  Eigen::MatrixXd cofactors;  ///< covariance of all unknowns
  double sigma_grey = 0;      ///< of a grey value, from residuals: noise and what the model does not describe
  int redundancy = 0;         ///< pixels less unknowns
  bool has_correlated_residuals = false;  ///< neighbouring pixels have residuals alike; the covariance allows for it
  [[nodiscard]] double contrast() const { return unknowns[6]; }
  [[nodiscard]] double sigma_px() const;  ///< of the centre in its worst direction
};

/// Measures the target whose centre is near a position, within a square window of 2 radius + 1 pixels. `radius_px`: of
/// the window, 4 or more, of chequerboards 3; a circle must lie in it with some pixels to spare. Covariance: from the
/// residuals, whose correlations up to two pixels are estimated and propagated where they are significant (3 sigmas).
/// Nothing: a window beyond the image, no contrast (below 5 sigmas of the residuals), a centre farther off than half
/// the radius, a shape that the window does not determine, an iteration that does not end.
[[nodiscard]] std::optional<Target> measure_target(const FloatImage& image, TargetKind kind,
                                                   const Eigen::Vector2d& near_px, int radius_px);
/// Below this radius a window is round, so that the corners of a square do not reach beyond a small target.
inline constexpr int kLeastSquareRadius_px = 4;
/// Whether a pixel of a window counts, its centre being so far from the target's.
[[nodiscard]] inline bool counts_in_window(int radius_px, const Eigen::Vector2d& from_target) {
  return radius_px >= kLeastSquareRadius_px || from_target.norm() <= radius_px + 0.6;
}
/// The same of a circle from its ellipse as edges give it.
[[nodiscard]] std::optional<Target> measure_circle(const FloatImage& image, const Ellipse& start);

struct TargetSearch {
  int radius_px = 8;              ///< of the window of crosses and chequerboards
  double least_contrast = 20;     ///< [grey]
  double largest_residual = 0.2;  ///< standard deviation of a grey value as part of the contrast
  std::size_t most = 2000;
};
/// All targets of a kind in an image, those of the smallest standard deviation first. Circles: among closed edges that
/// are ellipses. Chequerboards: where the Hessian of the smoothed image has a saddle, and a ring about it changes its
/// grey value four times. Crosses: where gradients have all directions, and a ring has four bars.
[[nodiscard]] std::vector<Target> find_targets(const FloatImage& image, const EdgeMap& edges, TargetKind kind,
                                               const TargetSearch& search);

}  // namespace collinea
