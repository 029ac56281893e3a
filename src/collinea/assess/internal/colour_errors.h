// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>

#include "collinea/assess/internal/ortho_errors.h"

namespace collinea {

/// Which image leads in the cells of an orthophoto: 1 + its index, 0 none. Null: not known.
using SourceReader = std::function<Result<FloatImage>(int column, int row, int width, int height)>;

struct ColourErrors {
  std::size_t pixels = 0;  ///< painted ones where the truth is known
  double share_wrong = 0;  ///< of these, showing another surface than the true one
  double rms_grey = 0;     ///< of the difference to the true colour, all pixels and channels
  std::size_t images = 0;  ///< that lead in enough pixels to tell their brightness
  double gain_rms = 0;     ///< how their brightness differs, relative, over images and channels
  double gain_worst = 0;
};

/// The colours of an orthophoto against the true ones. An image's gain is the median ratio to the truth over its
/// pixels; the mean of the gains of all images is free, per channel, since a block may be brighter than its truth
/// as a whole, and divided off. A pixel shows the wrong surface when one of its channels lies by more than 25 grey
/// levels outside of what the truth holds within 2 pixels around. Both need three channels at least. Errors: reading;
/// nothing in common; cancelled.
[[nodiscard]] Result<ColourErrors> colour_errors(const ImageField& product, const SourceReader& sources,
                                                 const ImageField& truth, const Run& run);

}  // namespace collinea
