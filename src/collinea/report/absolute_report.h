// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// An absolute orientation and what the control says of it.
struct AbsoluteReport {
  /// A control or check point; its components X, Y, Z (of a plane X, Y).
  struct Point {
    std::string name;
    Eigen::Vector3d misfit, sigma, redundancy, w;  ///< sigma and w by VarianceTest::factor()
    bool has_plan = true, has_height = true;
    bool is_check = false;     ///< only compared
    bool is_rejected = false;  ///< contradicts the others, only compared
  };
  struct Ground {
    std::string name;
    Eigen::Vector3d position, sigma;
  };
  std::string closed_form;  ///< the word of a closed form; empty: least squares
  int iterations = 0;
  bool is_plane = false;  ///< X and Y alone
  std::vector<Estimate> parameters;
  Eigen::MatrixXd covariance;  ///< of them; empty without
  std::vector<Estimate> inverse_parameters;
  VarianceTest variance;
  std::vector<Point> points;
  std::vector<Ground> ground;  ///< all points of the model
  int full = 0, plan = 0, height = 0;
  int solutions = 1;
  std::vector<Finding> findings;
};

[[nodiscard]] std::string absolute_text(const AbsoluteReport& report);
/// parameters, correlations, residuals, ground.
[[nodiscard]] std::vector<NamedTable> absolute_tables(const AbsoluteReport& report);

}  // namespace collinea
