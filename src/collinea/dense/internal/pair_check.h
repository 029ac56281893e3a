// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"
#include "collinea/dense/internal/disparity_map.h"

namespace collinea::dense {

/// Errors: an empty image, different heights, a range that is empty, has more than 2000 disparities or lies beyond the
/// images.
[[nodiscard]] Result<> check_pair(const GreyImage& left, const GreyImage& right, const DisparityRange& range);

}  // namespace collinea::dense
