// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "collinea/import/internal/imported.h"
#include "collinea/io/position_file.h"

namespace collinea {

/// Gives images the positions, attitudes and times of a file, in place of those of their headers. Exposures without a
/// name belong to the images whose names end in their number (before the extension), in the folder that is called like
/// the beginning of the file's name where several have it. What does not fit becomes a finding. Heights on a
/// map count from what its CRS says, else from `heights` of the options. Answers the images whose positions are now
/// those of the file. Errors: no image is in the file, a name that several images have, a CRS that PROJ does not know.
Result<std::set<ImageId>> add_positions(Imported& imported, const PositionFile& file, const std::filesystem::path& path,
                                        const ImportOptions& options);

/// Brings omega, phi, kappa of the file to the world frame, once the block has it.
Result<> add_map_attitudes(Imported& imported, const PositionFile& file);

}  // namespace collinea
