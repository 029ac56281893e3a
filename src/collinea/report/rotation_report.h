// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace collinea {

/// One rotation in all forms.
struct RotationReport {
  struct Form {
    std::string name;
    std::vector<std::pair<std::string, double>> values;  ///< empty: this form has none
    bool is_singular = false;                            ///< one angle is free and was set to zero
    Eigen::MatrixXd covariance = {};                     ///< in the units of the values; empty: none
  };
  Eigen::Matrix3d matrix;
  std::optional<Eigen::Matrix3d> sigma_matrix = {};  ///< of its elements
  double given_error = 0;                            ///< of the matrix as given, from orthonormal
  std::string unit;                                  ///< of angles
  std::vector<Form> forms;
};

[[nodiscard]] std::string rotation_text(const RotationReport& report);

}  // namespace collinea
