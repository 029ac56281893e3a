// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "collinea/base/result.h"
#include "collinea/io/adjustment_file.h"

namespace collinea {

/// Reads the text that PhotoModeler exports of a project for other bundle programs (*-pmexport.txt of DBAT): camera
/// (fixed), images with their orientation, control (a standard deviation of 0 or below: fixed), object points and
/// marks. Control is called by its number. Text in UTF-8 or UTF-16. Errors name the line, what is wrong in it and what
/// is expected.
///
/// Marks with standard deviations of 0 in x and y state none: PhotoModeler writes them of SmartPoints, which its
/// matching made. They get the one that the project states of image coordinates (the first number of the third line
/// [px]), or 1 px where that is not above 0. DBAT then takes 1 px of all marks, those that state another included.
///
/// Control is what PhotoModeler's own adjustment made of it: adjusted coordinates, and their standard deviations
/// behind the adjustment. Weighted as given it would be counted twice; put surveyed coordinates in its place.
[[nodiscard]] Result<AdjustmentFile> parse_photomodeler(std::string_view text);

/// Whether the text looks like it: a title, then five lines of numbers.
[[nodiscard]] bool is_photomodeler(std::string_view text);

}  // namespace collinea
