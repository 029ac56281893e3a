// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/raster/raster.h"
#include "collinea/surface/internal/gridding.h"

namespace collinea {

/// How uncertain images and cameras make a height, by themselves, at a point of the map.
struct PositionSigma {
  double x = 0, y = 0, sigma_m = 0;
};

/// The same everywhere: between the positions by their variances, each weighted with 1 / distance^2; the nearest eight
/// count. That is taken on a lattice over a raster and bilinear in between. Without positions it is zero.
class OrientationSigma {
 public:
  OrientationSigma(std::span<const PositionSigma> position_sigmas, const CellWindow& raster, double cell_m);

  /// Adds it to the standard deviations of a window of cells; those that are kNoHeight stay.
  void add_to(FloatImage& sigma_m, const CellWindow& window) const;

 private:
  CellWindow raster_;
  double step_ = 1;      // of the lattice [cells]
  FloatImage variance_;  // its nodes: those of the border lie on the raster's
};

}  // namespace collinea
