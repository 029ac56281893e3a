// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/geometry/rigid3.h"

namespace collinea {

/// An image point and what it shows: a point in space, or of a plane (z is not looked at).
struct ProjectedPoint {
  Eigen::Vector2d in_image;  ///< as a camera has it: x right, y down
  Eigen::Vector3d in_object;
  double sigma = 1;  ///< of one image coordinate, in its unit
};

/// A projective map from the object to the image, image ~ M (object, 1), by least squares in the image.
struct ProjectionFit {
  Eigen::Matrix<double, 3, Eigen::Dynamic> matrix;  ///< 3 x 4 (space) or 3 x 3 (plane), unit norm
  Eigen::MatrixXd covariance;                       ///< of its elements row by row, by the stated sigmas; singular
  int redundancy = 0;
  double sigma0 = 1;  ///< 1 without redundancy
  int iterations = 0;
  std::vector<Eigen::Vector2d> misfits;          ///< measured minus computed
  std::vector<Eigen::Vector2d> redundancies, w;  ///< local; Baarda's test, 0 where nothing checks
};

/// The direct linear transformation with 11 parameters (Abdel-Aziz and Karara 1971; Bolognesi 2.3.3): six points or
/// more in space, then Gauss-Newton in the image. Nothing when the points leave the matrix open: on a plane, or on a
/// twisted cubic with the projection centre; or when one lies behind the camera.
[[nodiscard]] std::optional<ProjectionFit> fit_projection(std::span<const ProjectedPoint> points);
/// The same of a plane with 8 parameters: four points or more, no three of four on a line.
[[nodiscard]] std::optional<ProjectionFit> fit_plane_projection(std::span<const ProjectedPoint> points);

/// The linear solution alone, by the least sum of squares of the equations multiplied by their denominators: a start.
/// Points in space: 3 x 4, six points; of a plane: 3 x 3, four. The first point lies before the camera. Nothing as
/// above.
[[nodiscard]] std::optional<Eigen::Matrix<double, 3, Eigen::Dynamic>> linear_projection(
    std::span<const ProjectedPoint> points, bool is_plane);

/// K of Bolognesi 2.1: [ax, -ax cot(theta), x0; 0, ay / sin(theta), y0; 0, 0, 1].
struct Decomposition {
  Eigen::Matrix3d calibration;  ///< upper triangular, positive diagonal, 1 in the corner
  Rigid3 cam_from_object;       ///< x right, y down, z forward
};
/// M = K [R | t] by the QR decomposition (Bolognesi 2.3.3.2). Nothing when the left 3 x 3 part is singular: a centre at
/// infinity.
[[nodiscard]] std::optional<Decomposition> decomposed(const Eigen::Matrix<double, 3, 4>& projection);

/// The projection centre: M (C, 1) = 0. Nothing at infinity.
[[nodiscard]] std::optional<Eigen::Vector3d> projection_centre(const Eigen::Matrix<double, 3, 4>& projection);
/// The unit direction of the ray of an image point, away from the camera where M has a positive determinant.
[[nodiscard]] std::optional<Eigen::Vector3d> ray_of(const Eigen::Matrix<double, 3, 4>& projection,
                                                    const Eigen::Vector2d& in_image);

/// The pose from the plane's matrix for a camera with known K: two columns are axes of the plane. Nothing when the
/// matrix is not one of a plane before that camera.
[[nodiscard]] std::optional<Rigid3> pose_of_plane(const Eigen::Matrix3d& plane_projection,
                                                  const Eigen::Matrix3d& calibration);

}  // namespace collinea
