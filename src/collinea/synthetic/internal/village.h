// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/synthetic/internal/country.h"

namespace collinea {

/// Hills, fields, two roads and scattered houses. Heights are 0 at the origin of the world. The same options
/// give the same scene.
[[nodiscard]] Scene make_village(const CountryOptions& options);

}  // namespace collinea
