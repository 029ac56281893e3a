// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/diverged.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

#include "collinea/report/adjustment_report.h"

namespace collinea {
namespace {

constexpr double kMostLost = 0.05;  // of the image points, where nothing is found that is grossly wrong
constexpr std::size_t kShown = 5;

// " (largest: P1 in A.jpg, ...)" of the tests of an adjustment; "" without tests.
std::string largest_suspects(const Examined& adjusted, const Block& block) {
  if (!adjusted.reliability) return "";
  const std::vector<TestedObservation>& suspects = adjusted.reliability->suspects;
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, suspects.size()); ++i)
    text += (i == 0 ? " (largest residuals: " : ", ") + name_of(suspects[i], block);
  return text.empty() ? text : text + ")";
}

}  // namespace

std::optional<Error> diverged(const Examined& adjusted, const GrossErrors& gross, const Block& block) {
  const std::string lost =
      fmt::format("{} of {} image points are where their image does not see their point", gross.lost_rays, gross.rays);
  if (adjusted.redundancy < 0)
    return Error{Errc::kIllPosed, fmt::format("{} unknowns but only {} observations are left: {}",
                                              adjusted.unknown_count, adjusted.observation_count, lost)};
  if (!adjusted.converged)
    return Error{Errc::kNotConverged, "the adjustment has not converged" + largest_suspects(adjusted, block)};
  if (gross.lost_rays == 0) return std::nullopt;
  if (!adjusted.reliability)
    return Error{Errc::kIllPosed, "the observations that are left do not determine the block: " + lost};
  if (gross.measurements.empty() && static_cast<double>(gross.lost_rays) < kMostLost * static_cast<double>(gross.rays))
    return std::nullopt;
  return Error{Errc::kNotConverged, "the adjustment has diverged: " + lost + largest_suspects(adjusted, block)};
}

Error naming(Error error, const GrossErrors& gross, const Block& block) {
  if (gross.measurements.empty())
    return std::move(error).advising(
        "; no few measurements explain it: look at the order of columns, at units, and at the approximate values");
  std::string text;
  for (std::size_t i = 0; i < std::min(kShown, gross.measurements.size()); ++i)
    text += (i == 0 ? "; what does not fit: " : "; ") + words_of_rejected(gross.measurements[i], block);
  if (gross.measurements.size() > kShown) text += fmt::format("; and {} more", gross.measurements.size() - kShown);
  return std::move(error).advising(text);
}

}  // namespace collinea
