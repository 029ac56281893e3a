// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "collinea/base/finding.h"

namespace collinea {

/// Findings of a single step, whose subjects are named and in no block: a line each with what to do, what is wrong
/// first; "" when there is none.
[[nodiscard]] std::string findings_text(std::span<const Finding> findings);

/// The same as JSON: {"findings": [...]}, each as in the reports of steps.
[[nodiscard]] std::string findings_json_text(std::span<const Finding> findings);

}  // namespace collinea
