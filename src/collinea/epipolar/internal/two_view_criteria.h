// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "collinea/block/features.h"
#include "collinea/epipolar/internal/point_pairs.h"

namespace collinea {

/// The pairs as they are when the focal lengths are these multiples of what was assumed.
[[nodiscard]] PointPairs with_focal_factor(const PointPairs& pairs, double first, double second);

/// Squared Sampson distances [px^2] of all pairs from a homography or from an essential or fundamental matrix.
[[nodiscard]] std::vector<double> errors_of(const Eigen::Matrix3d& matrix, const PointPairs& pairs, bool is_homography);

/// The items below a threshold, ascending.
[[nodiscard]] std::vector<int> below(const std::vector<double>& squared_px2, double threshold_px);

/// The sum of the squared errors, each cut off at the threshold [px^2].
[[nodiscard]] double truncated_cost(const std::vector<double>& squared_px2, double threshold_px);

/// Geometric robust information criterion (Torr, IJCV 2002) of a relation over the pairs `items`: dimension 3 for
/// epipolar geometry, 2 for a homography; its number of parameters. The relation with the smaller value is the better
/// one.
[[nodiscard]] double gric(const std::vector<double>& squared_px2, std::span<const int> items, double sigma_px,
                          int dimension, int parameters);

/// The smaller standard deviation of the scatter of some points [px]: 0 for points on a line.
[[nodiscard]] double breadth_px(const std::vector<Eigen::Vector2d>& points, std::span<const int> items);

/// How far a homography is from a rotation, scale apart.
[[nodiscard]] double distance_from_rotation(const Eigen::Matrix3d& homography);

/// Whether it would be rare (1 in 100) that as many as `inliers` of randomly placed matches agree on some epipolar
/// geometry within a threshold: the expected number of such sets among all five-pair models (Moisan and Stival, IJCV
/// 2004). A random match is right by chance with the area of the band around a line over the area which the points of
/// the second image fill.
[[nodiscard]] bool beyond_chance(const std::vector<Eigen::Vector2d>& second_px, std::size_t inliers,
                                 double threshold_px);

/// The matches without those that stay at their pixel (within 1.5 px) while the image moves: marks, dates and dirt,
/// which are in every image at the same position. Where the scene itself hardly moves somewhere, because it is far away
/// or turns about that position, there are as many matches that move a little: fewer than a quarter as many between 1.5
/// and 6 px as within 1.5 px, and five of these at least, are a sign of marks. Otherwise all matches are given back.
[[nodiscard]] std::vector<Match> without_marks(std::span<const Keypoint> first, std::span<const Keypoint> second,
                                               std::span<const Match> matches);

/// Whether nearly all of some matches (nine tenths) stay within 1.5 px of their pixel.
[[nodiscard]] bool nearly_all_still(std::span<const Keypoint> first, std::span<const Keypoint> second,
                                    std::span<const Match> matches);

/// How a keypoint differs between two images: turn [rad] and binary logarithm of the ratio of scales.
struct RotationAndScale {
  double rotation_rad, log2_scale;
};

/// The third of the items whose changes agree with most others (a vote in cells of 20 degrees and half an octave, with
/// their neighbours), ascending. Right matches of one pair of images turn and scale much the same; wrong ones do not.
[[nodiscard]] std::vector<int> most_alike(std::span<const RotationAndScale> changes);

}  // namespace collinea
