// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/geodesy/local_frame.h"
#include "collinea/project/project.h"

namespace collinea {

/// How the products of an oriented block lie on the map, and how fine they can be.
struct ProductFrame {
  std::optional<LocalFrame> frame;  ///< nothing: the block has no location on Earth
  bool metric = false;              ///< lengths are metres; else they are in a unit of the block's own
  double pixel_m = 0;               ///< ground size of a pixel of the images
  double matched_pixel_m = 0;       ///< of the images that were matched densely

  [[nodiscard]] const LocalFrame* frame_or_null() const { return frame ? &*frame : nullptr; }
};
[[nodiscard]] Result<ProductFrame> product_frame_of(const Project& project, const Block& block);

}  // namespace collinea
