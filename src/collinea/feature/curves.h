// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <complex>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

// Descriptions of curves in an image: what edges are once they are linked. Positions in px, x right, y down; a closed
// curve does not repeat its first point.
namespace collinea {

using Curve = std::vector<Eigen::Vector2d>;

/// Its length; of a closed curve with the way back to the first point.
[[nodiscard]] double length_of(std::span<const Eigen::Vector2d> curve, bool is_closed);
/// The area within a closed curve, positive when it runs from x to y (clockwise as an image is seen).
[[nodiscard]] double area_of(std::span<const Eigen::Vector2d> curve);
/// `count` points at the same distance along it, from its first one; of an open curve to its last one. Empty: a curve
/// without length, fewer than two points asked for.
[[nodiscard]] Curve resampled(std::span<const Eigen::Vector2d> curve, bool is_closed, int count);

/// The points that are left when a polygon is nowhere farther than the tolerance from the curve (Ramer 1972, Douglas
/// and Peucker 1973); of a closed curve the two points that are farthest apart are kept first.
[[nodiscard]] Curve polygon_of(std::span<const Eigen::Vector2d> curve, bool is_closed, double tolerance_px);

/// Freeman's chain code (1961): steps between pixels, 0 to the right (x), then by 45 degrees anticlockwise as the image
/// is seen: 2 is up, 4 left, 6 down. Steps longer than a pixel are drawn as straight lines.
struct ChainCode {
  int x = 0, y = 0;  ///< column and row of the first pixel
  std::vector<std::uint8_t> steps;
};
[[nodiscard]] ChainCode chain_code(std::span<const Eigen::Vector2d> curve, bool is_closed);
/// The middles of its pixels, the first one included.
[[nodiscard]] Curve curve_of(const ChainCode& code);

/// A point of the psi-s representation: the direction of the tangent at a length along the curve. Straight pieces are
/// level, circles are straight lines with the slope of their curvature, corners are steps; a rotation shifts psi.
struct PsiS {
  double s_px = 0;
  double psi_rad = 0;           ///< from x to y, continuous: it goes on beyond a turn
  double curvature_per_px = 0;  ///< d psi / d s, positive to the right (towards y from x)
  double sigma_curvature = 0;   ///< for errors of 1 px across the curve in each point, independent, or as given
  double sigma_psi_rad = 0;     ///< for the same errors
};
/// Covariance [px^2] of the errors across a curve of two of its points, by their numbers.
using AcrossCovariance = std::function<double(std::size_t, std::size_t)>;

/// By a parabola through the points within `window_px` along the curve on either side (at least two of them on each; at
/// the ends of an open curve fewer), that is kappa = y'' / (1 + y'^2)^(3/2) in the frame of the chord. Empty: fewer
/// than five points. With the parabola y = A c of points whose errors have the covariance C (no covariance: 1), cov(c)
/// = N^-1 A' C A N^-1, N = A' A, sigma of psi that of y' over 1 + y'^2, of kappa that of y'' over (1 + y'^2)^(3/2).
[[nodiscard]] std::vector<PsiS> psi_s(std::span<const Eigen::Vector2d> curve, bool is_closed, double window_px,
                                      const AcrossCovariance& covariance = {});

/// Fourier descriptors of a curve z = x + iy, resampled to a power of two N >= 2 `harmonics`: z(k) = sum c_n exp(2 pi i
/// n k / N). An open curve is followed back (its descriptors are those of a closed curve of twice the length).
struct FourierDescriptors {
  std::vector<std::complex<double>> at;  ///< of -harmonics .. harmonics
  [[nodiscard]] int harmonics() const { return int(at.size() / 2); }
  [[nodiscard]] std::complex<double> operator()(int n) const { return at[std::size_t(n + harmonics())]; }
  /// The curve that they stand for, at `count` points.
  [[nodiscard]] Curve curve(int count) const;
  /// |c_n / c_1|, n = -harmonics .. -1, 2 .. harmonics: the same after a shift, a rotation, a change of scale and from
  /// another first point. `c_1` must not vanish: a curve that runs the other way is to be reversed first.
  [[nodiscard]] std::vector<double> invariants() const;
};
/// Empty: fewer than three points, a curve without length.
[[nodiscard]] FourierDescriptors fourier_descriptors(std::span<const Eigen::Vector2d> curve, bool is_closed,
                                                     int harmonics);

}  // namespace collinea
