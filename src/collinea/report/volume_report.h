// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/surface/volume.h"

namespace collinea {

[[nodiscard]] std::string volume_json(const Volume& volume);
/// For a terminal. `sigmas_assumed`: no raster beside the surface stated the standard deviations of its heights.
[[nodiscard]] std::string volume_text(const Volume& volume, bool sigmas_assumed);

}  // namespace collinea
