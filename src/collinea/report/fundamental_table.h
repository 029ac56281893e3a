// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "collinea/io/text_table.h"

namespace collinea {

/// Three rows of three numbers, of which every digit stands: the fundamental matrix of pixels.
[[nodiscard]] TextTable fundamental_table(const Eigen::Matrix3d& fundamental);

}  // namespace collinea
