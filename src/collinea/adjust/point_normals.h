// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cmath>

#include "collinea/adjust/kind_image_point.h"

namespace collinea::bundle {

/// The symmetric 3 x 3 normal matrix of a point (xx xy xz yy yz zz), its right side, and its damped Cholesky factor.
struct PointNormals {
  double v[6] = {};
  double right[3] = {};
  double l[6] = {};  // l00 l10 l11 l20 l21 l22

  /// An image point.
  void add(const LinearRay& ray) {
    const double *a = ray.by_point, *b = ray.by_point + 3, *r = ray.residual;
    v[0] += a[0] * a[0] + b[0] * b[0];
    v[1] += a[0] * a[1] + b[0] * b[1];
    v[2] += a[0] * a[2] + b[0] * b[2];
    v[3] += a[1] * a[1] + b[1] * b[1];
    v[4] += a[1] * a[2] + b[1] * b[2];
    v[5] += a[2] * a[2] + b[2] * b[2];
    for (int c = 0; c < 3; ++c) right[c] += a[c] * r[0] + b[c] * r[1];
  }
  /// The weighted coordinates of a control point; answers their cost.
  double add(const ControlCoordinates& control, const double* point) {
    constexpr int kDiagonal[3] = {0, 3, 5};
    double cost = 0;
    for (int c = 0; c < 3; ++c) {
      if (!(control.inverse_sigma[c] > 0)) continue;
      const double w = control.inverse_sigma[c], r = (control.given[c] - point[c]) * w;
      v[kDiagonal[c]] += w * w;
      right[c] += w * r;
      cost += r * r;
    }
    return control.correlated() ? cost + add_off_diagonal(control, point) : cost;
  }
  double add_off_diagonal(const ControlCoordinates& control, const double* point) {
    const double* p = control.off_diagonal_weight;
    const double d[3] = {control.given[0] - point[0], control.given[1] - point[1], control.given[2] - point[2]};
    v[1] += p[0];
    v[2] += p[1];
    v[4] += p[2];
    right[0] += p[0] * d[1] + p[1] * d[2];
    right[1] += p[0] * d[0] + p[2] * d[2];
    right[2] += p[1] * d[0] + p[2] * d[1];
    return 2 * (p[0] * d[0] * d[1] + p[1] * d[0] * d[2] + p[2] * d[1] * d[2]);
  }
  /// Factors v + lambda diag(v). Directions that nothing fixes are fixed by a minute weight.
  void factor(double lambda) {
    const double floor = 1e-12 * (v[0] + v[3] + v[5]) + 1e-300;
    const double d0 = v[0] * (1 + lambda) + floor, d1 = v[3] * (1 + lambda) + floor, d2 = v[5] * (1 + lambda) + floor;
    l[0] = std::sqrt(d0);
    l[1] = v[1] / l[0];
    l[3] = v[2] / l[0];
    l[2] = std::sqrt(std::max(d1 - l[1] * l[1], floor));
    l[4] = (v[4] - l[1] * l[3]) / l[2];
    l[5] = std::sqrt(std::max(d2 - l[3] * l[3] - l[4] * l[4], floor));
  }
  /// x := L^-1 x
  void forward(double* x) const {
    x[0] /= l[0];
    x[1] = (x[1] - l[1] * x[0]) / l[2];
    x[2] = (x[2] - l[3] * x[0] - l[4] * x[1]) / l[5];
  }
  /// x := L^-T x
  void backward(double* x) const {
    x[2] /= l[5];
    x[1] = (x[1] - l[4] * x[2]) / l[2];
    x[0] = (x[0] - l[1] * x[1] - l[3] * x[2]) / l[0];
  }
};

}  // namespace collinea::bundle
