// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/camera/camera.h"
#include "collinea/epipolar/robust_start.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

struct ResectOptions {
  double max_error_px = 4;
  int min_inliers = 12;
  double min_inlier_ratio = 0.1;
  double confidence = 0.9999;
  int max_trials = 5000;
  RobustStart start = RobustStart::kTruncated;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ResectOptions;
    visit(Field{"max_error_px", &O::max_error_px, "px", "largest reprojection error of an inlier", 1e-6});
    visit(Field{"min_inliers", &O::min_inliers, "1", "fewest inliers of an accepted pose", 4});
    visit(Field{"min_inlier_ratio", &O::min_inlier_ratio, "1", "smallest share of inliers of an accepted pose", 0.0,
                1.0});
    visit(Field{"confidence", &O::confidence, "1", "wanted chance of one sample without outliers", 0.0, 1.0});
    visit(Field{"max_trials", &O::max_trials, "1", "upper bound of samples drawn", 1});
    visit(Field{"start", &O::start, "", "by what the pose is found among wrong points"});
  }
};

/// A pose found from known points.
struct Resection {
  Rigid3 cam_from_world;
  Camera camera;                     ///< as given; with the focal length found in resect_with_focal
  std::vector<std::uint8_t> inlier;  ///< per point
  int inliers = 0;
  double rms_px = 0;  ///< of the inliers, per point (not per coordinate)
};

/// The pose of a camera that sees `points_in_world[i]` at `pixels[i]`, among wrong pairs: random samples of three
/// (p3p), improved locally, then Gauss-Newton on the reprojection errors through the full camera model with a smooth
/// cap (Geman-McClure). By the least median of squares or the least sum of absolute errors (ResectOptions::start) the
/// errors themselves tell what is wrong: beyond 3.04 robust standard deviations, max_error_px at most, a pixel at
/// least. Nothing when too few points agree or they do not determine the pose (points on a line).
[[nodiscard]] std::optional<Resection> resect(const Camera& camera, std::span<const Eigen::Vector2d> pixels,
                                              std::span<const Eigen::Vector3d> points_in_world,
                                              const ResectOptions& options, std::uint64_t seed);

/// The same when the focal length is only guessed: factors of the given one from 0.5 to 2 are tried, the best is kept
/// and refined with the pose. A plane seen frontally does not determine the focal length: the answer is then any that
/// fits.
[[nodiscard]] std::optional<Resection> resect_with_focal(const Camera& camera, std::span<const Eigen::Vector2d> pixels,
                                                         std::span<const Eigen::Vector3d> points_in_world,
                                                         const ResectOptions& options, std::uint64_t seed);

}  // namespace collinea
