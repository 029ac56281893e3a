// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A point measured in three images: undistorted image coordinates (X/Z, Y/Z).
struct TriplePoint {
  Eigen::Vector2d first, second, third;
};

/// One of the sixteen ways to join two models of three images: each pair has four orientations (relative_solutions()).
struct ThreeImageCombination {
  int of_first = 0, of_second = 0;  ///< which of the four; 0 is the choice of the pair alone
  double base_ratio = 0;   ///< length of the second base over that of the first, by the median of the common points
  double scatter = 0;      ///< median deviation of single points from it, relative
  bool is_joined = false;  ///< all points give it one sign, and its scatter is that of the best one
  int in_front = 0;        ///< points in front of all three images
};

/// Three images joined.
struct ThreeImages {
  std::array<ThreeImageCombination, 16> combinations;  ///< ordered by of_first, of_second
  int chosen = 0;                                      ///< index of the combination
  Rigid3 second_from_first, third_from_first;          ///< base of the first pair: 1
};

/// Joins the models of images 1-2 and 2-3 over their common points (Mussio 3.3.4, D.3): the distance of a point from
/// the second image, in both models, gives the ratio of the bases. Of the sixteen combinations those in which all
/// points agree on it are geometrically acceptable: two, mirror images of each other, one of which has all points in
/// front (Mussio lets control points choose). Nothing with fewer than two common points with depth, or when no
/// combination has most of them in front.
[[nodiscard]] std::optional<ThreeImages> join_three_images(const Rigid3& second_from_first,
                                                           const Rigid3& third_from_second,
                                                           std::span<const TriplePoint> points);

}  // namespace collinea
