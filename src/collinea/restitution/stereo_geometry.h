// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"
#include "collinea/dense/epipolar_pair.h"
#include "collinea/geodesy/local_frame.h"

// What a stereoplotter shows: two photographs in the epipolar geometry of their poses, and a floating mark in both.
// docs/theory/stereo.md#stereoplotting.
namespace collinea {

/// The floating mark: at (x, y) of the left epipolar image and at (x - parallax, y) of the right one [px].
struct StereoMark {
  double x = 0, y = 0, parallax = 0;
};

/// Two oriented images as a person sees them: epipolar_pair() with the image on the left for which x along the base
/// runs as its own rows do, so that both are turned by a right angle at most against how the photograph lies.
///
///     parallax = cx_l - cx_r + f base / z,    X_l = z ((x - cx_l) / f, (y - cy) / f, 1)
///
/// with z the depth in the left camera of the pair (Kraus, Photogrammetry 2, normal case).
struct StereoGeometry {
  ImageId left, right;
  EpipolarPair pair;

  /// Errors: an image that there is not or that is not oriented; those of epipolar_pair().
  static Result<StereoGeometry> of(const Block& block, ImageId one, ImageId other);

  /// Nothing: the rays of the mark do not meet in front of the cameras.
  [[nodiscard]] std::optional<Eigen::Vector3d> position_in_world(const StereoMark& mark) const;
  /// Nothing: the point lies behind the cameras.
  [[nodiscard]] std::optional<StereoMark> mark_at(const Eigen::Vector3d& position_in_world) const;
  /// Where the photographs, left and right, show the mark: distortion and additional parameters included. Nothing: one
  /// of them does not.
  [[nodiscard]] std::optional<std::array<Eigen::Vector2d, 2>> pixels_of(const Block& block,
                                                                        const StereoMark& mark) const;
};

/// Where a photograph shows the pixels of its epipolar image: exact at the nodes, bilinear between them.
struct PixelLattice {
  int step_px = 64;                    ///< between nodes, in the epipolar image; node (0, 0) at its corner (0, 0)
  int columns = 0, rows = 0;           ///< of nodes; they reach to the end of the image or beyond
  std::vector<Eigen::Vector2d> nodes;  ///< row by row, in pixels of the photograph; NaN: it shows nothing there
  double error_px = 0;                 ///< the largest found in the middle of cells and of their sides

  /// Bilinear; NaN beside a node that has nothing, or outside.
  [[nodiscard]] Eigen::Vector2d at(double x, double y) const;
};
inline constexpr double kLatticeError_px = 0.05;

/// Of one image of the pair; steps of 64 pixels, or halved as often as it takes (to 8) to keep the error of what lies
/// on the photograph within kLatticeError_px. Errors: kUnsupported, 8 do not do.
[[nodiscard]] Result<PixelLattice> pixel_lattice(const Camera& camera_of_image,
                                                 const Eigen::Quaterniond& epipolar_from_image, const Camera& epipolar);

/// Map coordinates as polynomials of the second degree of u = (position_in_world - origin) / scale_m; of each of
/// easting, northing, height the coefficients of 1, x, y, z, xx, xy, xz, yy, yz, zz.
struct MapPolynomial {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double scale_m = 1;
  Eigen::Matrix<double, 3, 10> coefficients = Eigen::Matrix<double, 3, 10>::Zero();

  [[nodiscard]] Eigen::Vector3d at(const Eigen::Vector3d& position_in_world) const;
};
/// By least squares over a cube of 2 reach_m about the origin; errors below a millimetre for 2 km and less (tested: the
/// terms of the third degree are (reach / radius of the Earth)^2 of the reach). `frame`: null where the map is the
/// world.
[[nodiscard]] MapPolynomial map_polynomial(const LocalFrame* frame, const Eigen::Vector3d& origin, double reach_m);

}  // namespace collinea
