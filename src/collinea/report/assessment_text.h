// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/assess/assess.h"

namespace collinea {

/// The assessment as lines of text: what, how many, and figures in metres, pixels and GSD. Programs read them, so that
/// their form is kept. What was not assessed has no line.
[[nodiscard]] std::string assessment_text(const Assessment& assessment);

}  // namespace collinea
