// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

/// Reads the text that PhotoModeler exports of a project for other bundle programs (*-pmexport.txt of DBAT): camera
/// (fixed), images with their orientation, control (a standard deviation of 0 or below: fixed), object points and
/// marks. Control is called by its number. Errors name the line, what is wrong in it and what is expected.
[[nodiscard]] Result<AdjustmentFile> parse_photomodeler(std::string_view text);

/// Whether the text looks like it: a title, then five lines of numbers.
[[nodiscard]] bool is_photomodeler(std::string_view text);

}  // namespace collinea
