// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/surface/height_point.h"

namespace collinea {

/// The points of a text table with columns X, Y, Z and, where known, sigma_Z [m]; names are not looked at. Errors: the
/// file, a column, a number that is missing, a sigma below 0.
[[nodiscard]] Result<std::vector<HeightPoint>> read_point_rows(const std::filesystem::path& path);

}  // namespace collinea
