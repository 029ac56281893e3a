// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace collinea {

/// L^-1 of a symmetric matrix  w = L L'  (Cholesky), written out: some ten nanoseconds where thousands are to be made.
/// Its rows weigh equations of the covariance w, and  w^-1 = root' root. False, and `root` is not to be used, when a
/// pivot is not above `least_pivot` (of a positive definite matrix all are above 0).
[[nodiscard]] inline bool inverse_root(const Eigen::Matrix3d& w, Eigen::Matrix3d& root, double least_pivot = 0) {
  const double pivot0 = w(0, 0);
  if (!(pivot0 > least_pivot)) return false;
  const double root00 = 1 / std::sqrt(pivot0), l10 = w(1, 0) * root00, l20 = w(2, 0) * root00;
  const double pivot1 = w(1, 1) - l10 * l10;
  if (!(pivot1 > least_pivot)) return false;
  const double root11 = 1 / std::sqrt(pivot1), l21 = (w(2, 1) - l20 * l10) * root11;
  const double pivot2 = w(2, 2) - l20 * l20 - l21 * l21;
  if (!(pivot2 > least_pivot)) return false;
  const double root22 = 1 / std::sqrt(pivot2);
  root << root00, 0, 0,                   //
      -l10 * root00 * root11, root11, 0,  //
      (l10 * l21 * root11 - l20) * root00 * root22, -l21 * root11 * root22, root22;
  return true;
}

}  // namespace collinea
