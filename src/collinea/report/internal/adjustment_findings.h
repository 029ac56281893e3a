// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "collinea/report/adjustment_report.h"

namespace collinea {

// Parts of the report of an adjustment: for the page, for the JSON, as tables. Sections are empty when there is nothing
// to tell.

/// Root mean squares at check points by ASPRS 2023, the accuracy of their survey included.
[[nodiscard]] std::string accuracy_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json accuracy_json(const AdjustmentReport& report);
/// Systematic errors: what is estimated since it was found, what is named, and every test.
[[nodiscard]] std::string systematic_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json systematic_json(const AdjustmentReport& report);
[[nodiscard]] std::string snooping_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json snooping_json(const AdjustmentReport& report);
/// Mean residuals of tie points on a grid over the format of each camera, and how far residuals are from normal ones.
[[nodiscard]] std::string residual_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json residual_json(const AdjustmentReport& report);
/// Tests of the order of residuals and of their distribution.
[[nodiscard]] std::string residual_test_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json residual_tests_json(const AdjustmentReport& report);
/// Correlations of the parameters of each camera, of these with poses, and within poses.
[[nodiscard]] std::string correlation_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json pose_correlation_json(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json camera_pose_correlation_json(const AdjustmentReport& report);
/// Images and tie points whose positions are known worst.
[[nodiscard]] std::string weak_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json weak_json(const AdjustmentReport& report);
/// Additional parameters of cameras: which are significant, which are alike, which to drop.
[[nodiscard]] std::string additional_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json additional_json(const AdjustmentReport& report);
/// What is observed and unknown, by kind; redundancy by the number of rays and over the block.
[[nodiscard]] std::string network_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json network_json(const AdjustmentReport& report);
[[nodiscard]] std::string rejected_csv(const Snooped& snooped);

}  // namespace collinea
