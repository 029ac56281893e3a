// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "collinea/base/id.h"

namespace collinea {

/// What a request asks for, as JSON of few levels: reading and writing call themselves for each. Throws what
/// nlohmann::json throws of a text that is none, and std::invalid_argument where it is nested too deep.
[[nodiscard]] nlohmann::ordered_json bounded_json(std::string_view body);

/// The number of an image, whether there is such a one or not. Throws std::invalid_argument of anything else.
[[nodiscard]] ImageId image_in(const nlohmann::ordered_json& number);

}  // namespace collinea
