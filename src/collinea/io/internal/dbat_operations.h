// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/io/adjustment_file.h"
#include "collinea/io/internal/xml.h"

namespace collinea {

/// Does to a project of DBAT what an operation of its script says: which parameters are estimated, what they begin
/// with, and what fixes the datum. `path` is the script's, for errors.
[[nodiscard]] Result<> apply_dbat_operation(const XmlElement& operation, double pixel_height_mm,
                                            const std::filesystem::path& path, AdjustmentFile& file);

}  // namespace collinea
