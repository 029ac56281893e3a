// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>

#include "collinea/base/result.h"
#include "collinea/import/internal/imported.h"
#include "collinea/io/control_file.h"

namespace collinea {

/// Adds to the heights of the images how high what they count from lies over the ellipsoid, for all of the block. Not
/// to positions of a file (`of_file`), which says itself what its heights are.
[[nodiscard]] Result<> raise_positions(Imported& imported, const std::set<ImageId>& of_file,
                                       const ImportOptions& options);

/// The world frame in the middle of positions or control, and both in it. Nothing without either. Errors: coordinate
/// systems, control.
[[nodiscard]] Result<> location_on_earth(Imported& imported, const ImportOptions& options, ControlFile control);

}  // namespace collinea
