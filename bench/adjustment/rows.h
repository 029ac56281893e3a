// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/base/run.h"

namespace collinea::bench {

/// One line of the table.
struct Row {
  std::string what, must, measured;
  bool ok = false;
};
using Rows = std::vector<Row>;

/// How much is simulated: 1 for the full table; less for a quick look, whose bounds are then wider.
struct Effort {
  int blocks = 600;         ///< of the comparison with real errors
  int blunder_blocks = 40;  ///< and of variance components
  int large_images = 1000, large_points = 200000;
};

[[nodiscard]] Rows true_errors(const Effort& effort, const Run& run);
[[nodiscard]] Rows dense_inverse(const Run& run);
[[nodiscard]] Rows free_network(const Run& run);
[[nodiscard]] Rows blunders(const Effort& effort, const Run& run);
[[nodiscard]] Rows variance_components(const Effort& effort, const Run& run);
[[nodiscard]] Rows large_block(const Effort& effort, const Run& run);

}  // namespace collinea::bench
