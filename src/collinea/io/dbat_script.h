// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

/// Reads a script of DBAT, the Damped Bundle Adjustment Toolbox, and the text files it names: cameras, images, marks,
/// control, prior orientations, which parameters are estimated, and the datum of a dependent relative orientation. Its
/// other operations (resection, intersection, bundle) are what an adjustment does anyway; plots and output are left
/// aside. Control is called by its label, or else by its number. Errors name file and line: what is wrong, and what
/// this reader does not know.
[[nodiscard]] Result<AdjustmentFile> read_dbat_script(const std::filesystem::path& path);

[[nodiscard]] bool is_dbat_script(std::string_view text);

}  // namespace collinea
