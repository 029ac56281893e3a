// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <set>
#include <string>

#include "collinea/jobs/internal/adjust_project_options.h"
#include "collinea/project/project.h"
#include "collinea/report/adjustment_report.h"

namespace collinea {

/// Adjusts the oriented block of a project once more and writes report and tables to PROJECT/adjustment. The project
/// itself stays as it is. Errors: not oriented yet; those of adjust().
[[nodiscard]] Result<AdjustmentReport> adjust_project(const Project& project, const AdjustProjectOptions& options);

/// Writes what adjust_project would adjust, as a text file that adjust_file reads. Errors: not oriented yet, disk.
Result<> export_adjustment(const Project& project, const AdjustProjectOptions& options,
                           const std::filesystem::path& file);

/// Adjusts measurements without a project: finds approximate values that are missing, and writes to `folder` what
/// adjust_project writes. A named set of free parameters takes the place of what the file says, but for the standard
/// deviations of those it frees. Errors: the file's, with its name and line; nothing to begin at; those of adjust().
[[nodiscard]] Result<AdjustmentReport> adjust_file(const std::filesystem::path& file,
                                                   const std::filesystem::path& folder,
                                                   const AdjustProjectOptions& options, const Run& run);

/// The file in our own format, whatever it was in: "converted".
Result<> convert_adjustment(const std::filesystem::path& file, const std::filesystem::path& converted);

}  // namespace collinea
