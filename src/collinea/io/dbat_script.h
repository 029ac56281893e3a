// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

/// Reads a script of DBAT, the Damped Bundle Adjustment Toolbox, and the text files it names: cameras, images, marks,
/// control, check points, prior orientations, which parameters are estimated, and the datum of a dependent relative
/// orientation. Its other operations (resection, intersection, bundle) are what an adjustment does anyway; what it says
/// of plots and output is left aside, and so are remarks. Anything else that is in a script takes part or is an error
/// that names file and line: what is wrong, and what this reader does not know. The parts say in detail what they read:
/// internal/dbat_camera.h, dbat_tables.h, dbat_operations.h.
///
/// Points are called by their labels, or else by their numbers. Check points take part as in DBAT: with their marks, as
/// tie points besides, and not with their coordinates.
///
/// Börlin, Grussenmeyer: Bundle adjustment with and without damping. Photogrammetric Record 28 (2013); the format is
/// that of DBAT's version 0.9 (dbat_script_version 1).
[[nodiscard]] Result<AdjustmentFile> read_dbat_script(const std::filesystem::path& path);

[[nodiscard]] bool is_dbat_script(std::string_view text);

}  // namespace collinea
