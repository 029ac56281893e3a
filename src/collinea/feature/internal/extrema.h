// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/feature/internal/octave_rows.h"

namespace collinea {

/// An extremum of the difference of Gaussians in one octave.
struct Extremum {
  float x = 0, y = 0;  ///< pixel indices of the octave (0 = centre of the first pixel)
  float level = 0;     ///< between the whole levels of blur; see blur_of_level
  float strength = 0;  ///< contrast (size of the extremum, as a part of the range from black to white) times roundness:
                       ///< 1 for a blob, 2 sqrt(r) / (r + 1) where the principal curvatures have the ratio r
};

/// Looks for the extrema of an octave that lie at least a few pixels inside, located by a quadratic in x, y and level
/// (Brown and Lowe 2002), with at least the given contrast and with principal curvatures of at most the given ratio.
class ExtremumSearch {
 public:
  static constexpr int kReach = 6;  ///< rows above and below a band that are looked at

  ExtremumSearch(double least_contrast, double edge_ratio) : least_contrast_(least_contrast), edge_ratio_(edge_ratio) {}

  void look(const Octave& octave, int begin, int end);  ///< at the rows of a band
  /// What was found in all bands, sorted by level, row, column.
  [[nodiscard]] std::vector<Extremum> found() &&;

 private:
  struct Located {
    int level, y, x;  // in this order: sorted by it
    Extremum extremum;
  };
  double least_contrast_, edge_ratio_;
  std::vector<Located> located_;
};

}  // namespace collinea
