// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/geodesy/local_frame.h"

namespace collinea {

/// The map in plan as programs without a database of CRS take it: "+proj=utm +zone=16 +datum=WGS84 +units=m +no_defs".
/// Nothing when it cannot be written so.
[[nodiscard]] std::optional<std::string> proj_text(const LocalFrame& frame);

}  // namespace collinea
