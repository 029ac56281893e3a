// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "collinea/project/project.h"

namespace collinea {

/// Writes the oriented block for other programs. Formats: "colmap" (text and binary model in the local world frame),
/// "bundler" (bundle.out and list.txt, likewise), "opk" (omega, phi, kappa in the map), "ply" (tie points), "las",
/// "laz" and "copc" (the dense cloud in the map, in that form whatever the project's is; with `tile_m` cut into squares
/// of the map, one file each, listed in tiles.csv). Errors: not oriented yet, unknown format, disk.
[[nodiscard]] Result<> export_block(Project& project, const std::filesystem::path& folder, const std::string& format,
                                    std::optional<double> tile_m = {});

}  // namespace collinea
