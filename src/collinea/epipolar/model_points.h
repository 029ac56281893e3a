// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/epipolar/relative_orientation.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A point of the model.
struct ModelPoint {
  Eigen::Vector3d position;
  Eigen::Matrix3d covariance;  ///< of the measurements and of the orientation they gave
  /// What is common to the points of a model: covariance of points i and j = by_orientation_i C by_orientation_j', C
  /// the covariance of the orientation as stated.
  Eigen::Matrix<double, 3, 5> by_orientation;
  Eigen::Vector3d parallax = {0, 0, 0};  ///< spatial parallax of the rays as measured
  bool in_front = true;
};

/// The model of a pair.
struct PairModel {
  std::vector<std::optional<ModelPoint>> points;  ///< of each pair; nothing for parallel rays
  ModelPoint second_centre;  ///< the first projection centre is the origin: both are points of the model
};

/// Model coordinates of the adjusted rays in the frame of the first camera (x right, y down, z forward) with a base of
/// that length, or, `y_up`, with x right, y up, z backwards as photogrammetry has them. The covariances are those of
/// a pair whose length of base is without error; rejected points get coordinates, too (of the middle of their
/// parallax), with the covariance that they would have as new points.
[[nodiscard]] PairModel model_points(const RelativeOrientation& orientation, std::span<const PairPoint> points,
                                     double base = 1, bool y_up = false);

/// The full covariance of the points of a model that are there, three rows each, then of the second projection centre.
[[nodiscard]] Eigen::MatrixXd full_covariance(const PairModel& model, const Matrix5& orientation);

}  // namespace collinea
