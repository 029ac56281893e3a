// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "collinea/report/single_step.h"

namespace collinea {

/// Whether and by which test measurements that contradict the others leave a fit.
struct Rejection {
  bool is_asked = false, sigmas_are_stated = false;
  double alpha = 0.001;
  int least_redundancy = 1;  ///< with so much none leaves any more
};

[[nodiscard]] inline double largest_test(double w) { return std::abs(w); }
template <class Derived>
[[nodiscard]] double largest_test(const Eigen::MatrixBase<Derived>& w) {
  return w.cwiseAbs().maxCoeff();
}

/// The fit of the measurements that take part; as long as the largest of their tests is beyond its limit and the others
/// can be fitted, again without that one. `fit()`: an optional or a Result with sigma0 and redundancy, of what takes
/// part at that time; `tests(found)`: a range of the tests w of its measurements; `is_rejected(k)`: the flag
/// of the k-th of them.
template <class Fit, class Tests, class Flag>
[[nodiscard]] auto fitted_with_rejection(const Rejection& rule, const Fit& fit, const Tests& tests,
                                         const Flag& is_rejected) {
  while (true) {
    auto found = fit();
    if (!found || !rule.is_asked || found->redundancy <= rule.least_redundancy) return found;
    const VarianceTest variance{found->sigma0, found->redundancy, rule.sigmas_are_stated, rule.alpha};
    std::size_t worst = 0, k = 0;
    double largest = 0;
    for (const auto& w : tests(*found)) {
      if (largest_test(w) > largest) {
        largest = largest_test(w);
        worst = k;
      }
      ++k;
    }
    if (!(largest / variance.of_tests() > variance.limit())) return found;
    auto&& flag = is_rejected(worst);
    flag = true;
    if (fit()) continue;
    flag = false;  // not enough is left without it
    return found;
  }
}

}  // namespace collinea
