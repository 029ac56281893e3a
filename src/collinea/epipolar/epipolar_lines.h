// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "collinea/camera/camera.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// The epipolar lines of the second image of a pair, and how well its orientation knows them. Image coordinates are
/// X/Z, Y/Z.
///
/// With E = [t]x R the line of the point x1 is E x1, and the distance of x2 from it is x2' E x1 / |(E x1)_xy|. Turning
/// the second camera by w changes E by [w]x E, moving the base b (t = -R b) by d changes it by -R [d]x.
class EpipolarLines {
 public:
  /// `covariance`: that of changed(); zero: the orientation is exact.
  explicit EpipolarLines(const Rigid3& second_from_first, const Matrix5& covariance = Matrix5::Zero());

  /// (a, b, c) with a^2 + b^2 = 1: a x + b y + c is the distance of (x, y) from the line of the point. Nothing at the
  /// epipole of the first image.
  [[nodiscard]] std::optional<Eigen::Vector3d> of(const Eigen::Vector2d& first) const;

  /// How the distance of `second` from the line of `first` changes with the five degrees of freedom of changed().
  /// `second` lies on the line or near it.
  [[nodiscard]] Vector5 distance_by_change(const Eigen::Vector2d& first, const Eigen::Vector2d& second) const;

  /// The standard deviation of that distance by the covariance of the orientation, correlations and all; errors of the
  /// two points come on top. Half the height of the band in which a homologous point is looked for is some three of it
  /// (Karfis 6.5 adds up the effects of the three angles as though they were independent).
  [[nodiscard]] double sigma(const Eigen::Vector2d& first, const Eigen::Vector2d& second) const;

 private:
  Eigen::Matrix3d essential_;
  std::array<Eigen::Matrix3d, 5> by_change_;
  Matrix5 covariance_;
};

/// The fundamental matrix F of a pair, x_second' F x_first = 0 of homogeneous pixels:
///     F = K_second^-T [t]x R K_first^-1,
/// of unit norm. Nothing where a camera bends rays (lens, fisheye, additional parameters): epipolar lines of its pixels
/// are curves.
[[nodiscard]] std::optional<Eigen::Matrix3d> fundamental_matrix(const Camera& first, const Camera& second,
                                                                const Rigid3& second_from_first);

}  // namespace collinea
