// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

/// The names that somebody may have meant who wrote another: up to `most` of those nearest by the number of characters
/// to be changed, added, dropped or exchanged with their neighbour (Damerau 1964), capitals counting half; none that
/// differ in more than a third of their characters (two of short names). Nearest first, equal ones as they stand.
[[nodiscard]] std::vector<std::string> nearest_names(std::string_view name, const std::vector<std::string>& names,
                                                     std::size_t most = 3);

/// Adds the names nearest to one that there is not behind an error about it: "...; did you mean X1 or X2?".
[[nodiscard]] Error with_nearest(Error error, std::string_view name, const std::vector<std::string>& names);

}  // namespace collinea
