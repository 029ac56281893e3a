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

/// How much is simulated. With fewer blocks than these, bounds that are shares of all errors are wider.
struct Effort {
  int blocks = 1800;        ///< of the comparison with real errors
  int gross_error_blocks = 40;  ///< and of variance components and instruments
  int large_images = 1000, large_points = 200000;

  [[nodiscard]] bool all_blocks() const { return blocks >= Effort{}.blocks; }
};

[[nodiscard]] Rows true_errors(const Effort& effort, const Run& run);
[[nodiscard]] Rows dense_inverse(const Run& run);
[[nodiscard]] Rows free_network(const Run& run);
[[nodiscard]] Rows gross_errors(const Effort& effort, const Run& run);
[[nodiscard]] Rows variance_components(const Effort& effort, const Run& run);
[[nodiscard]] Rows weak_blocks(const Run& run);
/// Gross errors in measurements on the ground and in attitudes.
[[nodiscard]] Rows survey_gross_errors(const Effort& effort, const Run& run);
/// Lever arm, shift, drift and boresight.
[[nodiscard]] Rows instruments(const Effort& effort, const Run& run);
/// Rows of a program beside this one that prints them.
[[nodiscard]] Rows rows_of(const std::string& command);
[[nodiscard]] Rows large_block(const Effort& effort, const Run& run);

}  // namespace collinea::bench
