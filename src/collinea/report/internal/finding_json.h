// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>

#include "collinea/report/finding_words.h"

namespace collinea {

/// {"code", "severity", "subjects": [{"kind", "name", "aspect", "axis"}], "figures": [{"name", "value", "unit"}],
/// "remedies": [{"code", "option": {"group", "field", "value"}}], "what", "remedy"}. Names as in the block; "axis" of
/// a camera's parameter is its name. The last two are the sentences.
[[nodiscard]] nlohmann::ordered_json finding_json(const Finding& finding, const Block& block);
[[nodiscard]] nlohmann::ordered_json findings_json(const std::vector<Finding>& findings, const Block& block);

}  // namespace collinea
