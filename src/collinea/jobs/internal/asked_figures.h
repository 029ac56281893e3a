// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/report/measured_report.h"

namespace collinea {

/// Figures that are asked for, a word and names of points each: lines of a file, or between semicolons. Errors: the
/// file; no figure of that word.
[[nodiscard]] Result<std::vector<MeasuredReport::Figure>> read_figures(const std::string& asked);

}  // namespace collinea
