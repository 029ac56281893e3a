// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/tie_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace collinea {
namespace {

constexpr std::array<int, 5> kLeastRays = {2, 3, 4, 6, 10};
constexpr std::size_t kFewestOfClass = 500;

struct Pool {
  int least_rays;
  std::vector<CheckedError> errors;
};

void append(std::vector<CheckedError>& all, const std::vector<CheckedError>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

// Small ones join the next larger class, the last the one before.
std::vector<Pool> pools_of(const std::vector<RayError>& errors) {
  std::vector<Pool> pools;
  for (const int rays : kLeastRays) pools.push_back({rays, {}});
  for (const RayError& one : errors) {
    if (one.error.directions == 0 || one.rays < kLeastRays.front()) continue;
    const auto above = std::upper_bound(kLeastRays.begin(), kLeastRays.end(), one.rays);
    pools[static_cast<std::size_t>(above - kLeastRays.begin() - 1)].errors.push_back(one.error);
  }
  std::vector<Pool> merged;
  for (Pool& pool : pools) {
    if (!merged.empty() && merged.back().errors.size() < kFewestOfClass)
      append(merged.back().errors, pool.errors);
    else
      merged.push_back(std::move(pool));
  }
  if (merged.size() > 1 && merged.back().errors.size() < kFewestOfClass) {
    append(merged[merged.size() - 2].errors, merged.back().errors);
    merged.pop_back();
  }
  return merged;
}

}  // namespace

std::optional<std::size_t> TieErrors::class_of(int rays) const {
  if (classes.empty()) return std::nullopt;
  const auto above = std::upper_bound(classes.begin(), classes.end(), rays,
                                      [](int count, const Class& one) { return count < one.least_rays; });
  return above == classes.begin() ? 0 : static_cast<std::size_t>(above - classes.begin() - 1);
}

const ErrorDistribution* TieErrors::of(int rays) const {
  const auto index = class_of(rays);
  return index ? &classes[*index].distribution : nullptr;
}

std::optional<TieLoss> loss_of(const TieErrors& errors) {
  if (errors.classes.empty()) return std::nullopt;
  const bool any_of_three = errors.classes.back().least_rays > 2;
  double count = 0, squares = 0, inverse = 0;
  for (const TieErrors::Class& one : errors.classes) {
    if (any_of_three && one.least_rays <= 2) continue;
    const auto n = static_cast<double>(one.errors);
    count += n;
    squares += n * one.distribution.scale * one.distribution.scale;
    inverse += n / one.distribution.degrees_of_freedom;
  }
  const double scale2 = squares / count;
  if (inverse == 0) return TieLoss{.sigma_factor = std::sqrt(scale2)};
  const double nu = count / inverse;
  return TieLoss{std::sqrt(scale2 * nu / (nu + 2)), Loss::kCauchy, std::sqrt(nu + 2)};
}

TieErrors fit_tie_errors(const std::vector<RayError>& errors) {
  TieErrors fitted;
  for (const Pool& pool : pools_of(errors))
    if (const auto distribution = fit_errors(pool.errors))
      fitted.classes.push_back({pool.least_rays, static_cast<long>(pool.errors.size()), *distribution});
  return fitted;
}

}  // namespace collinea
