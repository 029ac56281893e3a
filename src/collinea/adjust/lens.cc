// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/lens.h"

#include <limits>

namespace collinea::bundle {
namespace {

// The smallest positive zero of d(r radial(r^2))/dr as a function of s = r^2, found by walking and halving.
double first_fold(double k1, double k2, double k3) {
  constexpr double kStep = 0.02, kWidest = 8;  // r^2 = 8: 141 degrees field of view
  const auto growth = [&](double s) { return 1 + s * (3 * k1 + s * (5 * k2 + s * 7 * k3)); };
  if (k1 >= 0 && k2 >= 0 && k3 >= 0) return std::numeric_limits<double>::infinity();
  double low = 0;
  while (low < kWidest && growth(low + kStep) > 0) low += kStep;
  if (low >= kWidest) return std::numeric_limits<double>::infinity();
  double high = low + kStep;
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    (growth(middle) > 0 ? low : high) = middle;
  }
  return low;
}

}  // namespace

Lens lens_of(const double* params) {
  Lens lens;
  lens.f = params[Camera::kF];
  lens.fx = params[Camera::kF] + params[Camera::kB1];
  lens.b2 = params[Camera::kB2];
  lens.cx = params[Camera::kCx];
  lens.cy = params[Camera::kCy];
  lens.k1 = params[Camera::kK1];
  lens.k2 = params[Camera::kK2];
  lens.k3 = params[Camera::kK3];
  lens.p1 = params[Camera::kP1];
  lens.p2 = params[Camera::kP2];
  lens.max_r2 = first_fold(lens.k1, lens.k2, lens.k3);
  return lens;
}

}  // namespace collinea::bundle
