// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/camera/camera.h"

namespace collinea {

/// A point of a plane and where an image shows it. Plane frame: x to the right and y up, seen from the front.
struct PlanePoint {
  std::string name;
  Eigen::Vector2d pixel;       ///< as measured, with the lens distortion [px]
  Eigen::Vector2d on_plane_m;  ///< [m]
  double sigma_px = 0.5;       ///< of each coordinate of the pixel
  double sigma_m = 0;          ///< of each coordinate on the plane
};

/// The central projection of a plane into an image by eight parameters, with their covariance. Coordinates of the
/// image are undistorted (X/Z, Y/Z of the camera).
class PlaneHomography {
 public:
  struct Residual {
    Eigen::Vector2d px;    ///< measured less computed
    Eigen::Vector2d m;     ///< the same on the plane
    double in_sigmas = 0;  ///< its length in standard deviations of the measurement
  };

  /// By least squares from four points or more: direct linear solution in whitened coordinates, then Gauss-Newton on
  /// the pixels, each point weighted by both of its sigmas. docs/theory/rectification.md. Errors (kIllPosed): fewer
  /// than four points, all but one on a line or nearly so, an order that no view of a plane gives, a mirrored order.
  static Result<PlaneHomography> fit(const Camera& camera, std::span<const PlanePoint> points);

  /// The ray of a position in the camera frame: matrix() * (x, y, 1), up to a positive factor. Its third coordinate is
  /// positive before the camera and zero on the horizon of the plane.
  [[nodiscard]] const Eigen::Matrix3d& matrix() const { return matrix_; }

  [[nodiscard]] const std::vector<Residual>& residuals() const { return residuals_; }
  [[nodiscard]] int redundancy() const { return redundancy_; }
  /// Standard deviation of unit weight: 1 when the sigmas stated are right; it says nothing without redundancy.
  [[nodiscard]] double sigma0() const { return sigma0_; }
  /// Whether residuals so large come from the sigmas stated in less than one of a thousand cases.
  [[nodiscard]] bool residuals_too_large() const;

  /// Covariance of the position that the homography gives an exactly measured pixel, from the sigmas stated [m^2]. The
  /// position: on the plane, before the camera.
  [[nodiscard]] Eigen::Matrix2d covariance_at(const Eigen::Vector2d& on_plane_m) const;

  /// The focal length in units of the camera's own [1] that makes the plane's axes perpendicular and equally long, and
  /// its standard deviation: the projection centre follows from it. Nothing when the view is too frontal to say (its
  /// standard deviation above a fifth). Assumes square pixels and the principal point of the camera.
  struct Focal {
    double times = 1, sigma = 0;  ///< the latter from the sigmas stated
  };
  [[nodiscard]] std::optional<Focal> focal() const;

 private:
  using Parameters = Eigen::Matrix<double, 8, 1>;
  PlaneHomography() = default;
  [[nodiscard]] static Eigen::Matrix3d as_matrix(const Parameters& parameters);

  Eigen::Matrix3d matrix_;
  Eigen::Matrix3d white_from_plane_;
  Parameters parameters_;  // of the homography from the whitened plane, the ninth is 1
  Eigen::Matrix<double, 8, 8> covariance_;
  std::vector<Residual> residuals_;
  int redundancy_ = 0;
  double sigma0_ = 0;
};

/// Where the camera stands in the frame of the plane (z towards the viewer) when `matrix` is the ray matrix of a camera
/// of `focal_times` the focal length that it was made with: least squares over both axes.
[[nodiscard]] Eigen::Vector3d centre_over_plane(const Eigen::Matrix3d& matrix, double focal_times = 1);

}  // namespace collinea
