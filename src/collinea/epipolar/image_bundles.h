// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/words.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A measurement of a point in one of a few images.
struct BundleMark {
  std::size_t image = 0, point = 0;
  Eigen::Vector2d in_image = Eigen::Vector2d::Zero();  ///< x right, y down
  double sigma = 1;                                    ///< of one coordinate, in its unit
};

/// What is unknown of the calibration matrix that all images share,
/// K = [c_x, s, x0; 0, c_y, y0; 0, 0, 1] (Bolognesi 2.1: s = -c_x cot(theta)).
enum class CalibrationUnknowns : std::uint8_t { kNone, kFocal, kFocalPoint, kAll };
inline constexpr Word<CalibrationUnknowns> kCalibrationUnknownsWords[] = {
    {CalibrationUnknowns::kNone, "none", "the calibration as given"},
    {CalibrationUnknowns::kFocal, "focal", "the principal distance, the same in x and y"},
    {CalibrationUnknowns::kFocalPoint, "focal_point", "principal distance and principal point"},
    {CalibrationUnknowns::kAll, "all", "principal distances in x and y, skew, principal point"}};
[[nodiscard]] constexpr std::span<const Word<CalibrationUnknowns>> words(CalibrationUnknowns) {
  return kCalibrationUnknownsWords;
}

/// How many they are: 0, 1, 3 or 5.
[[nodiscard]] int count_of(CalibrationUnknowns unknowns);

/// The bundles of a few images and their points, before the adjustment and after it.
struct ImageBundles {
  Eigen::Matrix3d calibration = Eigen::Matrix3d::Identity();
  std::vector<Rigid3> cam_from_model;
  std::vector<Eigen::Vector3d> points;
};

/// One measurement after the adjustment.
struct BundleMarkTest {
  Eigen::Vector2d misfit = Eigen::Vector2d::Zero();                                   ///< measured minus computed
  Eigen::Vector2d redundancy = Eigen::Vector2d::Zero(), w = Eigen::Vector2d::Zero();  ///< local; 0 where unchecked
};

struct AdjustedBundles {
  ImageBundles bundles;
  /// By stated sigmas: 6 for each image [rotation about the axes of the model (rad), centre], then 5 of c_x, c_y, s,
  /// x0, y0. Rows of what is fixed are zero.
  Eigen::MatrixXd covariance;
  std::vector<Eigen::Matrix3d> point_covariances;
  std::vector<BundleMarkTest> marks;
  int redundancy = 0, iterations = 0;
  double sigma0 = 1;  ///< 1 without redundancy
  /// Smallest over largest eigenvalue of the normal matrix of images and calibration with unit diagonal.
  double conditioning = 0;
};

/// Least squares of the bundles of a few images with a common calibration that is known or estimated with them,
///     u = K (R (X - C)) / depth,   v' P v = min,   Cov = (A' P A)^-1 by Schur complement of the points.
/// The datum is the first camera (fixed) and its distance from the camera of the image `unit_base`, which is 1: 7
/// parameters. Redundancy: measurements less 6 (m - 1) - 1 + 3 n + unknowns of K. Cost grows with the measurements and
/// the cube of the images.
///
/// Errors (ill-posed): fewer measurements than unknowns; a point that fewer than two images see; a point behind a
/// camera; a normal matrix with unit diagonal whose smallest eigenvalue is below 1e-12 (with unknown calibration: a
/// critical motion, Sturm 1997; in particular cameras without rotation, or turned about parallel axes); and steps that
/// do not settle in 50 while a calibration 30 % off, held or on their way, fits as well by a test of 0.1 % (the same
/// motion, nearly); not converged otherwise. Source: Bolognesi 6.1.3; Triggs and others 2000.
[[nodiscard]] Result<AdjustedBundles> adjust_bundles(const ImageBundles& start, std::span<const BundleMark> marks,
                                                     CalibrationUnknowns unknowns = CalibrationUnknowns::kNone,
                                                     std::size_t unit_base = 1);

}  // namespace collinea
