// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A measurement of a point in one of the images that are resected together.
struct ResectionMark {
  std::size_t image = 0, point = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< as the camera has it
  double sigma_px = 1;                              ///< of one coordinate
};

/// What is known of a point: a coordinate is exact (sigma 0), measured, or free (infinite). Free in all: a tie point.
struct ResectionPoint {
  Eigen::Vector3d in_world = Eigen::Vector3d::Zero();  ///< of a free one: nothing is read
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();

  [[nodiscard]] bool is_exact() const { return sigma_m.isZero(0); }
  [[nodiscard]] bool is_known() const { return sigma_m.allFinite(); }
};

/// One coordinate against the others.
struct MarkTest {
  Eigen::Vector2d misfit = Eigen::Vector2d::Zero();      ///< measured minus computed
  Eigen::Vector2d redundancy = Eigen::Vector2d::Zero();  ///< local
  Eigen::Vector2d w = Eigen::Vector2d::Zero();           ///< Baarda's test by the stated sigmas; 0 where unchecked
};

/// How near the geometry is to one that leaves the pose of an image open.
struct PoseConditioning {
  double ratio = 0;  ///< smallest over largest eigenvalue of the pose's normal matrix with unit diagonal
  /// The motion that is determined worst: [rotation about the axes of the world, centre], of unit length in that
  /// scale.
  Eigen::Matrix<double, 6, 1> weakest = Eigen::Matrix<double, 6, 1>::Zero();
};

struct SpaceResection {
  std::vector<Rigid3> cam_from_world;
  /// By stated sigmas, 6 for each image: [rotation about the axes of the world (rad), centre (m)].
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Vector3d> points;             ///< adjusted; exact ones as given
  std::vector<Eigen::Matrix3d> point_covariances;  ///< zero of exact ones
  std::vector<MarkTest> marks;                     ///< in their order
  std::vector<Eigen::Vector3d> point_w;            ///< tests of measured control coordinates
  std::vector<PoseConditioning> conditioning;      ///< for each image
  int redundancy = 0, iterations = 0;
  double sigma0 = 1;  ///< 1 without redundancy
};

/// Space resection of one image, or of several at once with their common control and tie points, by least squares on
/// the collinearity equations through the camera model; observed are image coordinates and control coordinates with a
/// sigma. Points with a sigma are eliminated one by one (Schur complement); cost grows with the points and with the
/// cube of the images. 6 unknowns an image, 3 a point that is not exact.
///
/// Errors (ill-posed): fewer measurements than unknowns; a normal matrix with unit diagonal whose smallest eigenvalue
/// is below 1e-12; a point behind a camera; not converged in 50 damped steps.
[[nodiscard]] Result<SpaceResection> space_resection(const Camera& camera, std::span<const Rigid3> starts,
                                                     std::span<const ResectionMark> marks,
                                                     std::span<const ResectionPoint> points);

/// A pose for the start of an image, by samples of three known points (p3p) and its errors at the others.
struct PoseStart {
  Rigid3 cam_from_world;
  double scale_px = 0;  ///< robust standard deviation of one coordinate; 0 without a fourth point
};
/// All poses by which three points are seen, each turned into [cam_from_world]; with four points and more the ones that
/// suit, best first. The criterion is the least median of squares over samples: all C(n, 3) of them, or `most` drawn
/// ones; up to nearly half of the points may be wrong. Empty when no sample has a pose.
[[nodiscard]] std::vector<PoseStart> pose_starts(const Camera& camera, std::span<const Eigen::Vector2d> pixels,
                                                 std::span<const Eigen::Vector3d> points_in_world, std::uint64_t seed,
                                                 std::size_t most = 500);

/// The danger cylinder of a resection: points on a circle, and the projection centre on the right cylinder over it.
struct DangerCylinder {
  double radius_m = 0;
  double points_off_m = 0;  ///< RMS of the points off the circle; 0 of three
  double centre_off_m = 0;  ///< of the projection centre off the cylinder: positive outside
  Eigen::Vector3d middle_in_world = Eigen::Vector3d::Zero();  ///< of the circle
  Eigen::Vector3d axis_in_world = Eigen::Vector3d::UnitZ();   ///< of the cylinder, of unit length
};
/// Nothing when the points lie on a line.
[[nodiscard]] std::optional<DangerCylinder> danger_cylinder(std::span<const Eigen::Vector3d> points_in_world,
                                                            const Eigen::Vector3d& centre_in_world);

}  // namespace collinea
