// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/report/single_step.h"

namespace collinea {

/// A control point after an adjustment: given minus computed, and its tests; 0 where nothing tests a coordinate.
struct ControlTest {
  std::string name;
  Eigen::Vector3d misfit_m = Eigen::Vector3d::Zero(), w = Eigen::Vector3d::Zero();
};

/// What an adjustment by itself finds of its measurements: residuals that contradict their standard deviations either
/// way (where these are stated), and the control point that contradicts the others most.
void add_fit_findings(const VarianceTest& variance, std::span<const ControlTest> control,
                      std::vector<Finding>& findings);

}  // namespace collinea
