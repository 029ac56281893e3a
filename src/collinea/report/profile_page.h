// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/surface/profile.h"

namespace collinea {

/// A page with the chart of a profile: each surface with its standard deviation as a band. `names`: of the surfaces.
[[nodiscard]] std::string profile_page(const Profile& profile, const std::vector<std::string>& names);

}  // namespace collinea
