// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/evaluation_text.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace collinea {
namespace {

constexpr double kArcsec = 180 * 3600 / std::numbers::pi;

std::string shift_text(const SurfaceShift& shift) {
  if (shift.unknowns == 0) return "co-registration  none\n";
  const auto sigma = [&](int i) { return std::sqrt(shift.covariance(i, i)); };
  std::string text = fmt::format("co-registration  by {} differences, {} beyond three robust sigmas left out\n",
                                 shift.used, shift.left_out);
  const char* const axes[] = {"east", "north", "up"};
  for (int i = 0; i < 3; ++i)
    text += fmt::format("  shift {:<6} {:>10.4f} m       sigma {:.4f}\n", axes[i], shift.values[i], sigma(i));
  for (int i = 3; i < shift.unknowns - 1; ++i)
    text += fmt::format("  turn {:<7} {:>10.2f} arcsec  sigma {:.2f}\n", axes[i - 3], shift.values[i] * kArcsec,
                        sigma(i) * kArcsec);
  if (shift.unknowns == 7)
    text += fmt::format("  scale        {:>10.2f} ppm     sigma {:.2f}\n", shift.values[6] * 1e6, sigma(6) * 1e6);
  return text + "  (the surface lies so against the reference; sigmas as though differences were independent)\n";
}

std::string row(const std::string& name, const DifferenceStatistics& of) {
  std::string text = fmt::format("{:<18} {:>10} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f}", name, of.count(),
                                 of.mean_m(), of.standard_deviation_m(), of.rms_m(), of.median_m(), of.nmad_m());
  for (std::size_t i = 0; i + 1 < DifferenceStatistics::kMultiples.size(); ++i)
    text += fmt::format(" {:>6.1f}", 100 * of.share_below(i));
  return text + fmt::format(" {:>6.1f}\n", 100 * (1 - of.share_below(DifferenceStatistics::kMultiples.size() - 1)));
}

std::string slope_name(std::size_t i) {
  if (i == kSlopeLimits_deg.size()) return fmt::format("slope > {} deg", kSlopeLimits_deg.back());
  return fmt::format("slope {}-{} deg", i == 0 ? 0 : kSlopeLimits_deg[i - 1], kSlopeLimits_deg[i]);
}

std::string class_name(int number, bool is_state) {
  if (is_state && number == 1) return "measured";
  if (is_state && number == 2) return "interpolated";
  return fmt::format("class {}", number);
}

}  // namespace

std::string evaluation_text(const Evaluation& evaluation) {
  const HeightComparison& comparison = evaluation.comparison;
  std::string text = shift_text(evaluation.shift);
  text += fmt::format("tolerance sigma  {:.4f} m{}\n", comparison.tolerance_m,
                      comparison.tolerance_from_data ? " (robust standard deviation of the differences)"
                      : evaluation.predicted_sigma_m ? " (predicted: k H/B sigma of a parallax, with the reference)"
                                                     : "");
  text += fmt::format("{:<18} {:>10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>6} {:>6} {:>6} {:>6} {:>6} {:>6}\n",
                      "surface - reference", "count", "mean[m]", "std[m]", "RMS[m]", "median[m]", "NMAD[m]", "<1s[%]",
                      "<3s[%]", "<4s[%]", "<5s[%]", "<6s[%]", ">10s[%]");
  text += row("all", comparison.all);
  for (std::size_t i = 0; i < comparison.by_slope.size(); ++i)
    if (comparison.by_slope[i].count() > 0) text += row(slope_name(i), comparison.by_slope[i]);
  for (const auto& [number, statistics] : comparison.by_class)
    text += row(class_name(number, evaluation.classes_are_states), statistics);
  if (comparison.without_height > 0)
    text += fmt::format("{} points of the reference lie where the surface has no height\n", comparison.without_height);
  if (comparison.variance_ratio)
    text += fmt::format(
        "the surface's own sigmas: mean square of difference / sigma {:.2f}, {:.1f} % within 1.96 sigmas (95 % are "
        "expected of an exact reference)\n",
        *comparison.variance_ratio, 100 * *comparison.within_bounds);
  if (std::abs(comparison.all.mean_m()) > comparison.all.standard_deviation_m())
    text += "the mean is larger than the scatter: surface and reference are offset in height as a whole\n";
  return text;
}

}  // namespace collinea
