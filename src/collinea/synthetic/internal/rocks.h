// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/synthetic/internal/country.h"

namespace collinea {

/// Steep bare rock with strata, rough at all wavelengths down to a metre, and few houses. Heights are 0 at the origin
/// of the world. The same options give the same scene.
[[nodiscard]] Scene make_rocks(const CountryOptions& options);

}  // namespace collinea
