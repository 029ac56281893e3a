// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/io/internal/dbat_project.h"

namespace collinea {

/// Reads the camera of a script, which it holds itself or names the file of, as number 0, with all its parameters
/// fixed. One camera; lens models 1 and 3 (measurements are corrected) and -1 (the lens distorts); a skew of model 3
/// alone. What a
/// calibration says of its own precision (`calibration_info`) is passed over, as DBAT does. Scripts count the rows of
/// the principal point downwards; a negative one is of those that count them upwards, from the upper edge on.
[[nodiscard]] Result<> read_dbat_camera(const XmlElement& input, DbatProject& project);

}  // namespace collinea
