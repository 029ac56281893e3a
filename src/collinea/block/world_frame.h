// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/block/block.h"
#include "collinea/geodesy/local_frame.h"

namespace collinea {

/// The world frame that a georeference stands for. Errors: those of LocalFrame::create.
[[nodiscard]] Result<LocalFrame> world_frame(const Georeference& georeference);

/// That of a block; nothing when its world frame has no location on Earth.
[[nodiscard]] Result<std::optional<LocalFrame>> world_frame(const Block& block);

}  // namespace collinea
