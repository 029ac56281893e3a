// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/jobs/internal/control_fit.h"
#include "collinea/report/absolute_report.h"
#include "collinea/report/factorisation_report.h"
#include "collinea/report/relative_report.h"
#include "collinea/report/triplet_report.h"

namespace collinea {

// What a user should know of orientations of several images and of models. Reports are complete but for their findings.

/// Points behind an image, and solutions between which nothing decides.
void add_choice_findings(const RelativeOrientation& orientation, std::span<const RelativeSolution, 4> solutions,
                         std::vector<Finding>& findings);

/// Few points, a weak or critical geometry, the choice of the solution, measurements that contradict or were rejected,
/// residuals against stated sigmas.
[[nodiscard]] std::vector<Finding> relative_findings(const RelativeReport& report);

/// Points for elements that are given: behind an image, against each other and their sigmas.
[[nodiscard]] std::vector<Finding> given_relative_findings(const RelativeReport& report);

/// The same of three images, and combinations of their pairs that are not one and its mirror image.
[[nodiscard]] std::vector<Finding> triplet_findings(const TripletReport& report);

/// Control that is little or near a line, contradicts or was rejected, check points that are off, orientations that fit
/// as well, residuals against stated sigmas.
[[nodiscard]] std::vector<Finding> absolute_findings(const AbsoluteReport& report, const ControlFit& control);

/// A scene near a plane, points not in all images, a calibration that is refuted, weak or missing, measurements that
/// contradict or were rejected, residuals against stated sigmas.
[[nodiscard]] std::vector<Finding> factorisation_findings(const FactorisationReport& report);

}  // namespace collinea
