// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/report/internal/summary.h"

namespace collinea {

/// The figures of the report as a JSON object: units in the names, null where something is not known.
[[nodiscard]] std::string report_json(const ReportInput& input, const ReportSummary& summary);

}  // namespace collinea
