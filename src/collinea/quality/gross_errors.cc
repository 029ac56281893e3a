// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/gross_errors.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/quality/internal/gross_choice.h"
#include "collinea/quality/internal/robust_fit.h"

namespace collinea {
namespace {

constexpr double kBent = 20, kBentInImage = 1000;  // standard deviations

}  // namespace

bool is_bent(const Result<Examined>& adjusted, const TestOptions& options) {
  if (!adjusted) return adjusted.error().code == Errc::kIllPosed;
  if (!adjusted->converged || !adjusted->reliability || adjusted->reliability->unseen > 0) return true;
  const double sigma0 = options.sigma0_known ? 1 : sigma_scale(*adjusted);
  return std::ranges::any_of(adjusted->reliability->suspects,
                             [&](const TestedObservation& one) { return std::abs(one.suspicion) * sigma0 > kBent; });
}

GrossErrors find_gross_errors(const Block& block, const AdjustScope& scope, const AdjustOptions& options,
                              const Adjusted* adjusted, const Run& run) {
  GrossErrors found;
  const Measurements given{block, with_first_cameras(scope, block.cameras)};
  std::set<Measurement> gross;
  if (const auto fit = robust_fit(given, options, run))
    for (const Misfit& one : gross_misfits(*fit)) {
      gross.insert(one.measurement);
      found.measurements.push_back(gross_rejection(one, given).rejected);
    }
  if (!adjusted) return found;
  for (const Misfit& one : misfits_of(given, *adjusted)) {
    found.rays += is_image_point(one.index.group);
    found.lost_rays += !std::isfinite(one.sigmas) && !gross.contains(one.measurement);
  }
  return found;
}

}  // namespace collinea
