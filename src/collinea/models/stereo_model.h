// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

namespace collinea {

/// A point of a model, in the model's own right-handed frame (u, v, w; any unit). The projection centres of its two
/// images are points like others; they have the same name in the neighbouring models.
struct NamedPoint {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();  ///< may be zero where the frame was chosen so
};

/// A photogrammetric model: the shape of what two images show, after their relative orientation, up to a similarity.
struct StereoModel {
  std::string name;
  std::vector<NamedPoint> points;  ///< each name once
  /// Of all coordinates (three rows a point, in their order), where they are correlated between points; empty: they are
  /// not, and NamedPoint::covariance says all.
  Eigen::MatrixXd covariance;

  [[nodiscard]] Eigen::MatrixXd full_covariance() const {
    if (covariance.size() > 0) return covariance;
    const auto n = static_cast<Eigen::Index>(points.size());
    Eigen::MatrixXd full = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (Eigen::Index i = 0; i < n; ++i)
      full.block<3, 3>(3 * i, 3 * i) = points[static_cast<std::size_t>(i)].covariance;
    return full;
  }
};

/// A point surveyed on the ground. Standard deviation of an axis: 0: fixed; infinite: not given (a plan or a height
/// point).
struct SurveyedPoint {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  bool is_check = false;  ///< only compared

  [[nodiscard]] bool has(int axis) const { return sigma[axis] < std::numeric_limits<double>::infinity(); }
  [[nodiscard]] bool has_plan() const { return has(0) && has(1); }
  [[nodiscard]] bool is_full() const { return has_plan() && has(2); }
};

}  // namespace collinea
