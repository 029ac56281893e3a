// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "collinea/feature/edge_fit.h"

namespace collinea {

/// An ellipse: centre, semi-axes and the direction of the major one.
struct Ellipse {
  Eigen::Vector2d centre = {};
  double major_px = 0, minor_px = 0;  ///< semi-axes
  double angle_rad = 0;               ///< of the major axis, from x to y; -pi/2 .. pi/2

  /// At the eccentric anomaly `t`; the derivatives after centre x, y, major, minor, angle.
  [[nodiscard]] Eigen::Vector2d at(double t_rad) const;
  [[nodiscard]] Eigen::Matrix<double, 2, 5> derivatives_at(double t_rad) const;
  /// The eccentric anomaly of the nearest point.
  [[nodiscard]] double foot_of(const Eigen::Vector2d& p) const;
  /// Distance of a point from it, positive outside.
  [[nodiscard]] double distance_px(const Eigen::Vector2d& p) const;
};

/// The ellipse of the conic p' C p = 0 of homogeneous points. Nothing: another conic, or none.
[[nodiscard]] std::optional<Ellipse> ellipse_of_conic(const Eigen::Matrix3d& conic);

struct EdgeEllipse {
  Ellipse ellipse;
  bool is_bright = false;                  ///< brighter inside than outside
  Eigen::Matrix<double, 5, 5> covariance;  ///< of centre x, y, major, minor [px], angle [rad]
  double arc_rad = 0;                      ///< how much of it has points, of 2 pi
  EdgeFitQuality quality;

  [[nodiscard]] Eigen::Matrix2d centre_covariance() const { return covariance.topLeftCorner<2, 2>(); }
};

/// Five points or more by least squares of the distances across the edge, from an algebraic start under the condition
/// of an ellipse (Fitzgibbon, Pilu and Fisher 1999, in the form of Halir and Flusser 1998). The angle of a circle is
/// not determined: within 0.1 % of one it is fixed, with a variance of 0. Nothing: fewer points, no ellipse, points on
/// too short an arc, an iteration that does not end.
[[nodiscard]] std::optional<EdgeEllipse> fit_ellipse(std::span<const EdgePoint> points, double along_px);

/// A circle of a plane in an image: its ellipse, the image of its centre, and how far the two centres are apart. The
/// centre of the ellipse is not the image of the centre: the nearer half of the circle covers more of the image.
struct CircleImage {
  Ellipse ellipse;
  Eigen::Vector2d centre = {};  ///< image of the centre
  [[nodiscard]] Eigen::Vector2d eccentricity() const { return ellipse.centre - centre; }
};
/// `image_from_plane`: the homography of the plane, positive third coordinate in front. Nothing: the circle reaches the
/// horizon.
[[nodiscard]] std::optional<CircleImage> image_of_circle(const Eigen::Matrix3d& image_from_plane,
                                                         const Eigen::Vector2d& centre_on_plane, double radius);

}  // namespace collinea
