// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/synthetic/internal/country.h"

namespace collinea {

/// Streets in two directions with rows of houses, gardens and trees between them. Heights are 0 at the origin of the
/// world. The same options give the same scene.
[[nodiscard]] Scene make_town(const CountryOptions& options);

}  // namespace collinea
