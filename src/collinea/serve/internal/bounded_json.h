// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

namespace collinea {

/// What a request asks for, as JSON of few levels: reading and writing call themselves for each. Throws what
/// nlohmann::json throws of a text that is none, and std::invalid_argument where it is nested too deep.
[[nodiscard]] nlohmann::ordered_json bounded_json(std::string_view body);

}  // namespace collinea
