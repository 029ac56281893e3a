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

/// A measurement of a point in an image after an adjustment: the larger of the tests of its coordinates.
struct MeasurementTest {
  std::string point, image;  ///< image may be empty
  double w = 0;
  std::size_t coordinates = 2;  ///< that were tested
};

/// Residuals that contradict their standard deviations either way, where these are stated. `of`: whose they are; empty:
/// of all.
void add_variance_finding(const VarianceTest& variance, std::vector<Finding>& findings, std::vector<Subject> of = {});

/// The same, that nothing checks the measurements, and the one that contradicts the others most: the largest test, at
/// the level of all of them together.
void add_measurement_findings(const VarianceTest& variance, std::span<const MeasurementTest> measurements,
                              std::vector<Finding>& findings);

/// Points that contradict the others and take no part: a note, weak where they are more than a fifth of all.
void add_rejected_finding(FindingCode code, std::span<const Subject> rejected, std::size_t of,
                          std::vector<Finding>& findings);

/// Each check point whose misfit is beyond what its standard deviation allows, at the level of all of them together.
void add_check_findings(const VarianceTest& variance, std::span<const ControlTest> checks,
                        std::vector<Finding>& findings);

/// What an adjustment by itself finds of its measurements: residuals that contradict their standard deviations either
/// way (where these are stated), and the control point that contradicts the others most, at the level of all tests
/// together (a coordinate whose w is 0 has none).
void add_fit_findings(const VarianceTest& variance, std::span<const ControlTest> control,
                      std::vector<Finding>& findings);

}  // namespace collinea
