// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/io/adjustment_file.h"
#include "collinea/project/project.h"
#include "collinea/report/adjustment_report.h"

namespace collinea {

/// Adjusts the oriented block of a project with other options, to see what would come of it, and writes report and
/// tables to `folder`. The project itself stays as it is. Errors: not oriented yet; those of adjust_block().
[[nodiscard]] Result<AdjustmentReport> try_adjustment(const Project& project, const AdjustmentOptions& options,
                                                      const std::filesystem::path& folder);

/// Writes what would be adjusted and how, as a text file that adjust_file repeats. Errors: not oriented yet, disk.
[[nodiscard]] Result<> export_adjustment(const Project& project, const AdjustmentOptions& options,
                                         const std::filesystem::path& file);

/// The measurements of a file, and how it says that they are adjusted.
struct FileAdjustment {
  std::filesystem::path path;
  AdjustmentFile file;
  AdjustmentOptions options;  ///< those it states, the others as they are by default
};

/// Reads our own format or one of others, whichever it is. Errors: the file's, with its name and line.
[[nodiscard]] Result<FileAdjustment> read_adjustment(const std::filesystem::path& file);

/// Adjusts measurements without a project, by the options that come with them: finds approximate values that are
/// missing, and writes report and tables to `folder`. A named set of free parameters takes the place of what the file
/// says, but for the standard deviations of those it frees. Errors: nothing to begin at; those of adjust_block().
[[nodiscard]] Result<AdjustmentReport> adjust_file(FileAdjustment given, const std::filesystem::path& folder,
                                                   const Run& run);
/// The same of a file, by these options alone, whatever it states.
[[nodiscard]] Result<AdjustmentReport> adjust_file(const std::filesystem::path& file,
                                                   const std::filesystem::path& folder,
                                                   const AdjustmentOptions& options, const Run& run);

/// The file in our own format, whatever it was in, with the options that are not as they are by default: "converted".
Result<> convert_adjustment(const FileAdjustment& given, const std::filesystem::path& converted);

}  // namespace collinea
