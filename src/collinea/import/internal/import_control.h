// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/geodesy/local_frame.h"
#include "collinea/import/internal/imported.h"
#include "collinea/io/control_file.h"

namespace collinea {

/// True when a point has a coordinate.
[[nodiscard]] bool is_surveyed(const ControlFile& control);

/// Brings surveyed points and their images into the block. What does not fit (an image that is not there, a pixel
/// outside its image) becomes a finding. `frame`: nullptr when nothing is surveyed. Errors: its CRS cannot be
/// converted.
Result<> add_control(Imported& imported, const ControlFile& control, const LocalFrame* frame);

/// Brings what was measured between control points into the block. Errors: no file, bad lines, points that are not
/// there.
Result<> add_geodetic(Imported& imported, const std::filesystem::path& file);

}  // namespace collinea
