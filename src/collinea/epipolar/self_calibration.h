// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/epipolar/image_bundles.h"
#include "collinea/epipolar/projective_factorisation.h"

namespace collinea {

/// The principal distance, the same in both images and in x and y, from a fundamental matrix, x2' F x1 = 0, and the
/// principal point of both: K' F K is essential, its two singular values are equal. With F = U diag(a, b, 0) V' and
/// w = K K' that are Kruppa's equations (Bolognesi 5.28, 5.4; Hartley and Zisserman 2004, 19.27; Sturm 2001),
///     (u2' w u2) / (a^2 v1' w v1) = -(u1' w u2) / (a b v1' w v2) = (u1' w u1) / (b^2 v2' w v2),
/// of which the outer ones give a quadratic equation for c^2; the root that meets the middle one is taken. Nothing
/// where no root is positive; for parallel optical axes, and for axes that meet at one distance from both centres.
[[nodiscard]] std::optional<double> focal_from_fundamental(const Eigen::Matrix3d& fundamental,
                                                           const Eigen::Vector2d& principal_point);

/// The fundamental matrix of each pair of images by least squares of distances from epipolar lines (Bolognesi 5.32),
/// and the principal distance that it states by itself.
struct PairFundamental {
  std::size_t first = 0, second = 0;
  Eigen::Matrix3d fundamental;  ///< of unit norm, of the coordinates as given
  std::optional<double> focal;
};
/// All pairs that have a fundamental matrix.
[[nodiscard]] std::vector<PairFundamental> fundamentals_of_pairs(const ImageCoordinates& measured,
                                                                 const Eigen::Vector2d& principal_point);

/// The calibration that all images share from the fundamental matrices of their pairs alone, by least squares of the
/// differences of singular values of all K' F K,
///     (p11 - p22, 2 p12) / (p11 + p22),  p = B' (E E') B,  B across the left epipole of E = K' F K
/// (Kruppa's equations as Mendonca and Cipolla 1999 weigh them), from a start. Two equations of a pair; nothing where
/// these are fewer than the unknowns, or do not determine them. It has no standard deviation: the equations of pairs of
/// the same images are not independent.
[[nodiscard]] std::optional<Eigen::Matrix3d> calibration_from_fundamentals(std::span<const PairFundamental> pairs,
                                                                           const Eigen::Matrix3d& start,
                                                                           CalibrationUnknowns unknowns);

/// A projective model in Euclidean form.
struct EuclideanUpgrade {
  ImageBundles bundles;                                         ///< first camera at the origin; base of `unit_base`: 1
  Eigen::Vector3d plane_at_infinity = Eigen::Vector3d::Zero();  ///< r of T, the first camera being [I|0]
  double misfit = 0;                                            ///< root mean square of the equations, relative
  int in_front = 0;                                             ///< points in front of all cameras
};

/// The Euclidean upgrade M_e = M_p T, T = [K 0; r' 1], of cameras with one calibration (Bolognesi 5.41-5.47): the
/// absolute dual quadric [KK', Kr; r'K', r'r] is seen by each camera as lambda^2 K K',
///     M_i [KK', Kr; r'K', r'r] M_i' / |...| - K K' / |K K'| = 0,
/// six equations of a camera, five of which count; with r and the unknowns of K by least squares. Starts: 40 principal
/// distances between 0.2 and 20 times `size`, each with the plane at infinity that the second cameras state in closed
/// form (Gherardi and Fusiello 2010). Those that fit best and differ, best first; among equal ones of a mirrored pair
/// that with the points in front. Empty with fewer than three images, or when all fail. `size`: a length of the image,
/// as its half width; K starts with the principal point and no skew.
[[nodiscard]] std::vector<EuclideanUpgrade> euclidean_upgrades(const ProjectiveModel& model,
                                                               const Eigen::Vector2d& principal_point, double size,
                                                               CalibrationUnknowns unknowns, std::size_t unit_base = 1);

/// The image that stands farthest from the first one, as the model of one calibration has it.
[[nodiscard]] std::size_t farthest_from_first(const ImageBundles& bundles);

/// Bundles of images with one unknown calibration, from nothing but their coordinates: the upgrades as starts of
/// adjust_bundles(), the best adjustment of them. Errors: no upgrade, and those of adjust_bundles(), critical motions
/// among them.
[[nodiscard]] Result<AdjustedBundles> self_calibrated(const ProjectiveModel& model, const ImageCoordinates& measured,
                                                      std::span<const EuclideanUpgrade> upgrades,
                                                      CalibrationUnknowns unknowns, std::size_t unit_base);

/// The calibrated path for the same measurements: relative orientation of the first image with every other one, bases
/// by the common points, then all bundles. Errors: those of relative_orientation() and adjust_bundles().
[[nodiscard]] Result<AdjustedBundles> calibrated(const ImageCoordinates& measured, const Eigen::Matrix3d& calibration,
                                                 std::size_t unit_base, std::uint64_t seed);

/// The measurements as adjust_bundles() has them.
[[nodiscard]] std::vector<BundleMark> marks_of(const ImageCoordinates& measured);

}  // namespace collinea
