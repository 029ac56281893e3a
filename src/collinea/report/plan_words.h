// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "collinea/plan/precision.h"
#include "collinea/plan/rules_of_thumb.h"

namespace collinea {

/// What a rule is of: "signalised points, plan".
[[nodiscard]] std::string_view words_of(PlanRule rule);

/// The rule itself: "6 um * mb"; h: height above ground, mb: image scale number.
[[nodiscard]] std::string_view formula_of(PlanRule rule);

/// What is customary: "forward overlap of 60 % and more".
[[nodiscard]] std::string_view words_of(PlanCustom custom);

/// What would be added: "one more control point", "projection centres by RTK (20, 20, 30 mm)".
[[nodiscard]] std::string words_of(const Gain& gain);

}  // namespace collinea
