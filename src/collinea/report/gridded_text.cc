// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/gridded_text.h"

#include <fmt/format.h>

#include <cmath>

namespace collinea {

std::string gridded_text(const GriddedPoints& gridded) {
  std::string text =
      fmt::format("{}: {} points, {} x {} cells of {:.4g} m, {} with a height\n", word_of(gridded.method),
                  gridded.points, gridded.grid.width, gridded.grid.height, gridded.grid.cell_m, gridded.cells);
  if (gridded.covariance) {
    const HeightCovariance& covariance = gridded.covariance->covariance;
    text += fmt::format("covariance  {}, signal {:.4f} m, range {:.3f} m, noise {:.4f} m beyond the points' own\n",
                        word_of(covariance.model), std::sqrt(covariance.signal_m2), covariance.range_m,
                        std::sqrt(covariance.noise_m2));
    text += "variogram  distance[m]  half_square[m2]  pairs\n";
    for (const VariogramClass& each : gridded.covariance->variogram)
      text += fmt::format("           {:>11.3f}  {:>15.6f}  {:>5}\n", each.distance_m, each.half_square_m2, each.pairs);
  }
  if (gridded.left_out > 0) {
    text += fmt::format("{} points left out and found from the others: RMS {:.4f} m", gridded.left_out,
                        gridded.left_out_rms_m);
    if (gridded.left_out_variance_ratio)
      text += fmt::format(", mean square of error over sigma {:.2f} (1 is expected)", *gridded.left_out_variance_ratio);
    text += "\n";
  }
  return text;
}

}  // namespace collinea
