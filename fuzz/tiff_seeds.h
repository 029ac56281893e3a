// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace collinea::fuzz {

/// Small TIFF files of the kinds that scanners and programs write: strips and tiles, 8 and 16 bits, grey, colour,
/// palette, inverted, several compressions.
[[nodiscard]] std::vector<std::string> tiff_seeds();

}  // namespace collinea::fuzz
