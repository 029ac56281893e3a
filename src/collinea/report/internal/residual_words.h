// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/finding.h"
#include "collinea/block/block.h"
#include "collinea/quality/residual_tests.h"

namespace collinea {

/// "positions, east", "means of images, columns".
[[nodiscard]] std::string residual_series_words(ResidualSeries series, int axis);
/// "east", "columns".
[[nodiscard]] std::string residual_axis_word(ResidualSeries series, int axis);

/// The sentences of findings on the order and the distribution of residuals.
[[nodiscard]] std::string residual_words(const Finding& finding, const Block& block);

}  // namespace collinea
