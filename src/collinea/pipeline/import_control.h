// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/geodesy/local_frame.h"
#include "collinea/io/control_file.h"
#include "collinea/pipeline/import.h"

namespace collinea {

/// Brings surveyed points and their images into the block. What does not fit (an image that is not there, a pixel
/// outside its picture, a point seen in fewer than two images) becomes a finding. Errors: its CRS cannot be converted.
Result<> add_control(Imported& imported, const ControlFile& control, const LocalFrame& frame);

}  // namespace collinea
