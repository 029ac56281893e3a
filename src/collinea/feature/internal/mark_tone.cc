// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/mark_tone.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr double kDarkest = 1;       // grey value: nothing is known of the curve below
constexpr double kLeastTone = 1e-3;  // about 0, which is the limit of a geometric mean

}  // namespace

ToneCurve::ToneCurve(double gain, double offset, double tone)
    : gain_(gain),
      offset_(offset),
      tone_(std::abs(tone) < kLeastTone ? kLeastTone : tone),
      ground_(std::max(offset, kDarkest)),
      mark_(std::max(offset + gain, kDarkest)),
      log_ratio_(std::log(mark_ / ground_)),
      rise_(std::expm1(tone_ * log_ratio_)) {}

TonedGrey ToneCurve::at(double share) const {
  if (tone_ == 1) return {gain_ * share + offset_, gain_, share, 1};
  // Interpolation overshoots the drawing a little: there is no light below none.
  const double inside = std::clamp(share, 0.0, 1.0);
  const double sum = 1 + inside * rise_, grey = ground_ * std::exp(std::log1p(inside * rise_) / tone_);
  const double by_mark = inside * std::pow(grey / mark_, 1 - tone_);
  const double by_ground = (1 - inside) * std::pow(grey / ground_, 1 - tone_);
  return {grey, grey * rise_ / (tone_ * sum), by_mark, by_mark + by_ground};
}

double ToneCurve::by_tone(double share) const {
  const double inside = std::clamp(share, 0.0, 1.0);
  const double sum = 1 + inside * rise_, log_sum = std::log1p(inside * rise_);
  return ground_ * std::exp(log_sum / tone_) *
         (inside * log_ratio_ * (1 + rise_) / (tone_ * sum) - log_sum / (tone_ * tone_));
}

}  // namespace collinea
