// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/base/finding.h"
#include "collinea/base/run.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea {

/// What an unknown contributes to a combination of unknowns.
struct UnknownShare {
  Subject unknown;
  double share = 0;  ///< of the sum of squares, 0 to 1
};

/// How well images, cameras and what stands among the global parameters can be told apart.
struct Conditioning {
  /// The largest variance that any combination of them has, over what it would be if everything else (points too) were
  /// known: 1 / the least eigenvalue of the reduced normal equations with each unknown in units of its own weight. Of
  /// sixteen digits its logarithm is lost. 0: not known.
  double inflation = 0;
  std::vector<UnknownShare> mostly;  ///< the up to three unknowns that this combination consists of most, descending
};

namespace bundle {

/// The unknown that a row of the reduced normal equations stands for: the attitude of an image, k1 of a camera.
[[nodiscard]] Subject subject_of_row(const Problem& problem, int row);

}  // namespace bundle

/// The worst combination of the reduced unknowns, with the factor of Solved::factor(). With D, the diagonal of the
/// normal equations before the points were eliminated, it is the eigenvector of the largest eigenvalue of D^1/2 N^-1
/// D^1/2, found by inverse iteration to 1 %: at most sixty solutions with the factor. In the datum of that factor.
[[nodiscard]] Conditioning conditioning_of(const Solved& solved, const bundle::TileCholesky& factor, const Run& run);

}  // namespace collinea
