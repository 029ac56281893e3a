// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <span>
#include <vector>

#include "collinea/camera/camera.h"
#include "collinea/epipolar/internal/point_pairs.h"
#include "collinea/epipolar/internal/verify_options.h"
#include "collinea/geometry/rigid3.h"
#include "collinea/math/random.h"

namespace collinea {

/// Two views that are compared, and how.
struct TwoViews {
  const Camera& first;
  const Camera& second;
  const VerifyOptions& options;
  double threshold_px = 0;              ///< largest residual of an inlier
  std::span<const int> preferred = {};  ///< pairs that are right more often
};

/// Epipolar geometry of a pair, with those who obey it.
struct EpipolarRelation {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();  ///< essential or fundamental, of `pairs`
  PointPairs pairs;                                  ///< with the focal length the matrix belongs to
  std::vector<int> inliers;
  int parameters = 5;
  std::optional<Rigid3> motion;
};

/// A plane in the scene, as its homography.
struct PlaneRelation {
  Eigen::Matrix3d matrix;  ///< of the nominal coordinates
  std::vector<int> inliers;
  std::vector<double> errors;
};

/// A rotation between the views.
struct RotationRelation {
  Eigen::Quaterniond rotation;
  std::vector<double> errors;
  int parameters;
};

inline constexpr double kAssumedFocal = 0.1;     // sigma_f / f beyond which a focal length is a guess
inline constexpr double kPlaneThreshold = 1.25;  // two degrees of freedom instead of one at the same 95 %
inline constexpr double kMotionShare = 0.7;  // of the fundamental matrix's inliers that an essential matrix must keep

/// The standard deviation of a camera's focal length over the focal length.
[[nodiscard]] inline double relative_sigma_f(const Camera& camera) {
  return camera.prior.sigma_f_px / camera.focal_px();
}

/// Rays nearer to parallel than this say nothing about before and behind.
[[nodiscard]] double blind_angle_rad(const TwoViews& views, const PointPairs& pairs);

/// The homography of the coordinates after multiplying the focal lengths.
[[nodiscard]] Eigen::Matrix3d conjugated(const Eigen::Matrix3d& h, double first, double second);

[[nodiscard]] EpipolarRelation by_essential(const TwoViews& views, const PointPairs& pairs, Random& random);

[[nodiscard]] EpipolarRelation by_fundamental(const TwoViews& views, const PointPairs& pairs, Random& random);

/// A plane is of interest when it explains at least half as much as the epipolar geometry.
[[nodiscard]] std::optional<PlaneRelation> by_plane(const TwoViews& views, const PointPairs& pairs,
                                                    std::size_t epipolar_inliers, Random& random);

/// The rotation that comes nearest to the homography, for the given focal length or, if it is uncertain, the best one
/// in its range.
[[nodiscard]] std::optional<RotationRelation> by_rotation(const TwoViews& views, const PlaneRelation& plane,
                                                          const PointPairs& pairs);

}  // namespace collinea
