// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/project/project.h"
#include "collinea/report/adjustment_report.h"

namespace collinea {

/// Adjusts the oriented block of a project with other options, to see what would come of it, and writes report and
/// tables to `folder`. The project itself stays as it is. Errors: not oriented yet; those of adjust_block().
[[nodiscard]] Result<AdjustmentReport> try_adjustment(const Project& project, const AdjustmentOptions& options,
                                                      const std::filesystem::path& folder);

/// Writes what would be adjusted, as a text file that adjust_file reads. Errors: not oriented yet, disk.
Result<> export_adjustment(const Project& project, const AdjustmentOptions& options, const std::filesystem::path& file);

/// Adjusts measurements without a project: finds approximate values that are missing, and writes report and tables to
/// `folder`. A named set of free parameters takes the place of what the file says, but for the standard deviations of
/// those it frees. Errors: the file's, with its name and line; nothing to begin at; those of adjust_block().
[[nodiscard]] Result<AdjustmentReport> adjust_file(const std::filesystem::path& file,
                                                   const std::filesystem::path& folder,
                                                   const AdjustmentOptions& options, const Run& run);

/// The file in our own format, whatever it was in: "converted".
Result<> convert_adjustment(const std::filesystem::path& file, const std::filesystem::path& converted);

}  // namespace collinea
