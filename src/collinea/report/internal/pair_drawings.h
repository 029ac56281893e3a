// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/report/internal/figures.h"
#include "collinea/report/pair_report.h"

namespace collinea {

// Drawings over the photographs of a pair, each a complete <svg>; without the photograph over a frame.

/// Some homologous points in the left (0) or right (1) image, each with the epipolar line of its partner in the other
/// one: curved where the lens bends it.
[[nodiscard]] std::string epipolar_drawing(const PairReport& report, int image, const std::optional<Preview>& photo);

/// What is left of the y-parallaxes, exaggerated: as vectors in the left image, of rejected points in another colour.
[[nodiscard]] std::string parallax_drawing(const PairReport& report, const std::optional<Preview>& photo);

}  // namespace collinea
