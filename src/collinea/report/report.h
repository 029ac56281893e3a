// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"
#include "collinea/report/internal/report_input.h"

namespace collinea {

/// Writes FOLDER/report.html (one file, no network needed, made to be printed) and FOLDER/report.json (the same figures
/// for programs), and with ReportInput::files FOLDER/hashes.json: these and the two of the report. The same input gives
/// the same bytes. A preview that cannot be read becomes a finding. Errors: disk.
[[nodiscard]] Result<> write_report(const ReportInput& input, const std::filesystem::path& folder);

}  // namespace collinea
