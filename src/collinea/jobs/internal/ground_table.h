// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

#include "collinea/base/result.h"
#include "collinea/io/text_table.h"

namespace collinea {

/// A point of a table of ground coordinates: what it does not state is not a number, with an infinite sigma.
struct GroundTablePoint {
  Eigen::Vector3d position, sigma;
};

/// Columns point, X, Y, Z, sigma_X, sigma_Y, sigma_Z. Errors: columns, a point twice, a negative sigma.
[[nodiscard]] Result<std::map<std::string, GroundTablePoint>> read_ground_table(const std::filesystem::path& path,
                                                                                double sigma_m, bool needs_height);

}  // namespace collinea
