// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/robust_squares.h"

namespace collinea {
namespace {

// The mean of w s over the coordinates of normal residuals with that variance; s is the variance times chi-squared.
double normal_mean(const Loss& loss, double variance, int coordinates) {
  constexpr int kPanels = 96;
  constexpr double kFarthest = 6;  // sigmas: 1e-8 of the errors lie beyond
  double weighted = 0, all = 0;
  for (int i = 1; i <= kPanels; ++i) {
    const double t = kFarthest * i / kPanels, t2 = t * t;
    const double share = (i % 2 ? 4 : 2) * std::exp(-t2 / 2) * t2 * (coordinates == 1 ? 1 : coordinates == 2 ? t : t2);
    weighted += share * loss.weight(variance * t2) * variance;
    all += share;
  }
  return weighted / all;
}

}  // namespace

void RobustSquares::add(double s, int coordinates) {
  const double across = loss_.weight(s), along = loss_.slope(s);
  ++count_[static_cast<std::size_t>(coordinates)];
  coordinates_ += coordinates;
  weighted_ += across * s;
  twice_weighted_ += across * across * s;
  weights_ += coordinates * across;
  slopes_ += (coordinates - 1) * across + along;
  squared_slopes_ += (coordinates - 1) * across * across + along * along;
}

// The variance of normal residuals whose mean of w s is that of these: it grows with it, less than in proportion.
double RobustSquares::variance() const {
  if (coordinates_ == 0 || weighted_ == 0) return 0;
  double variance = weighted_ / coordinates_;
  if (loss_.kind == Loss::kNone) return variance;
  constexpr int kMostRounds = 100;
  for (int round = 0; round < kMostRounds; ++round) {
    double expected = 0;
    for (int c = 1; c <= 3; ++c)
      if (const double count = count_[static_cast<std::size_t>(c)]; count > 0)
        expected += count * c * normal_mean(loss_, variance, c);
    const double factor = weighted_ / expected;
    variance *= factor;
    if (std::abs(factor - 1) < 1e-9) break;
  }
  return variance;
}

double RobustSquares::squares() const { return variance() * coordinates_; }

double RobustSquares::information(double unknowns_per_coordinate) const {
  if (loss_.kind == Loss::kNone || coordinates_ == 0 || weighted_ == 0) return 1;
  const double slope = slopes_ / coordinates_, spread = squared_slopes_ / coordinates_ - slope * slope;
  if (!(slope > 0)) return 1;
  const double k = 1 + unknowns_per_coordinate * spread / (slope * slope);
  const double of_estimate = k * k * twice_weighted_ / coordinates_ / (slope * slope);
  return variance() / (of_estimate * weights_ / coordinates_);
}

}  // namespace collinea
