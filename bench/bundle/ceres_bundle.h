// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/block/block.h"

namespace collinea::bench {

enum class CeresSolver { kDense, kSparse, kIterative };

/// Of the processor, all threads of this program together.
[[nodiscard]] double cpu_seconds();

struct CeresOutcome {
  double seconds = 0;          ///< all of ceres::Solve; of the processor, as the next
  double seconds_to_cost = 0;  ///< until the cost was first at most the one asked for; all of it when never
  bool reached = false;
  int iterations = 0;
  double final_cost = 0;                            ///< sum of squared whitened residuals after the loss
  double jacobian_seconds = 0, linear_seconds = 0;  ///< by the clock, as Ceres tells them
};

/// The adjustment of adjust() with calibration = Calibration::kBrown and its default losses, as a problem of Ceres:
/// points eliminated first, analytic derivatives of image points. Ends as soon as the cost is at most `wanted_cost`.
[[nodiscard]] CeresOutcome ceres_bundle(const Block& block, const Block& first_cameras, CeresSolver solver, int threads,
                                        double wanted_cost);

}  // namespace collinea::bench
