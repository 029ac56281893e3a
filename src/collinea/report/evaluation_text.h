// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/assess/height_comparison.h"

namespace collinea {

/// A surface beside its reference.
struct Evaluation {
  SurfaceShift shift;
  HeightComparison comparison;
  std::optional<double> predicted_sigma_m;  ///< of one difference, by scale, base and image coordinates
  bool classes_are_states = false;          ///< the classes are CellState: measured, interpolated
};

/// For a terminal and as a file: shift with standard deviations, table of Karfis (2009, 8.2), by slope and by class.
[[nodiscard]] std::string evaluation_text(const Evaluation& evaluation);

}  // namespace collinea
