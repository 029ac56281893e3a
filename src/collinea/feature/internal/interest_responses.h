// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

#include "collinea/feature/interest_options.h"
#include "collinea/feature/internal/tensor_patch.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A strip of an image: the operators see it as an image of its own.
struct ImageStrip {
  const GreyImage& image;
  int begin, width;
};

/// Receives the responses of a row of a strip.
using ResponseSink = std::function<void(int y, const float* row)>;

/// The responses of an operator at all pixels of a strip, its border repeated outwards, upper row first.
void interest_responses(const ImageStrip& strip, const InterestOptions& options, const ResponseSink& sink);

/// The same of an operator on the structure tensor, round single pixels.
[[nodiscard]] TensorPatch tensor_patch_of(const InterestOptions& options);

}  // namespace collinea
