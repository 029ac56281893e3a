// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "collinea/block/block.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// The record of a step as a JSON object under the names that its members have: images by their files in `block`, null
/// for what is not known. Of a step that made no product only why. What an orientation has of single images, points and
/// cameras is left out: reports show it in tables of its own.
[[nodiscard]] nlohmann::ordered_json figures_of(const StepOutcome& outcome, const Block& block);

}  // namespace collinea
