// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "collinea/report/adjustment_report.h"

namespace collinea {

// Parts of the report of an adjustment: for the page, for the JSON, as tables. Sections are empty when there is nothing
// to tell.

[[nodiscard]] std::string snooping_section(const AdjustmentReport& report);
[[nodiscard]] nlohmann::ordered_json snooping_json(const AdjustmentReport& report);
[[nodiscard]] std::string taken_out_csv(const Snooped& snooped);

}  // namespace collinea
