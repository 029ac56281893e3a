// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/tag_model.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kFar = 5;  // sigmas beyond which a cell tells nothing of a pixel
constexpr double kLeastBlurPx = 0.2, kLargestBlurPx = 8;

double phi(double u) { return 0.5 * std::erfc(-u / std::numbers::sqrt2); }
double density(double u) { return std::exp(-u * u / 2) / std::sqrt(2 * std::numbers::pi); }

Matrix2d axes_of(const VectorXd& u) {
  Matrix2d a;
  a << u[kTagShape], u[kTagShape + 1], u[kTagShape + 2], u[kTagShape + 3];
  return a;
}
Vector2d tilt_of(const VectorXd& u) { return u.segment<2>(kTagShape + 4); }

// What relates a pixel to the tag: M = A - d g', d = p - c; q = M^-1 d; w = 1 + g' q. Positions on the tag change by
// w M^-1 per pixel.
struct Local {
  Vector2d d, q, g;
  Matrix2d m, inverse;
  double w = 1, determinant = 0;
  Local(const VectorXd& u, const Vector2d& p) : d(p - u.head<2>()), g(u[kTagShape + 4], u[kTagShape + 5]) {
    m << u[kTagShape] - d.x() * g.x(), u[kTagShape + 1] - d.x() * g.y(), u[kTagShape + 2] - d.y() * g.x(),
        u[kTagShape + 3] - d.y() * g.y();
    determinant = m(0, 0) * m(1, 1) - m(0, 1) * m(1, 0);
    inverse << m(1, 1) / determinant, -m(0, 1) / determinant, -m(1, 0) / determinant, m(0, 0) / determinant;
    q = inverse * d;
    w = 1 + g.dot(q);
  }
  // Lengths of the gradients of both coordinates on the tag [1/px], and the cosine between them: standard deviations
  // of a blur, and its correlation.
  [[nodiscard]] Vector2d gradients() const { return std::abs(w) * inverse.rowwise().norm(); }
  [[nodiscard]] double cosine() const {
    return inverse.row(0).dot(inverse.row(1)) / (inverse.row(0).norm() * inverse.row(1).norm());
  }
};

// Light at a position of the tag [cells], blurred by two sigmas [cells] and their correlation; its derivatives.
struct Light {
  double value = 0, by_correlation = 0;
  Vector2d by_position = Vector2d::Zero(), by_log_sigma = Vector2d::Zero();
  bool is_flat = true;
};

// What the correlation adds to the bivariate normal distribution at (a, b), and its derivatives:
//     Phi2(a, b; r) - Phi(a) Phi(b) = 1 / 2 pi  int_0^asin(r) exp(-(a^2 + b^2 - 2 a b sin t) / 2 cos^2 t) dt
// by Gauss and Legendre; r is the sine of the angle by which the axes of the tag are not at right angles.
struct ByCorrelation {
  double value, by_a, by_b, by_r;
};
ByCorrelation by_correlation(double a, double b, double r) {
  constexpr std::array<double, 3> kNodes{0.1127016653792583, 0.5, 0.8872983346207417},
      kWeights{5 / 18., 8 / 18., 5 / 18.};
  const double end = std::asin(r), rest = std::sqrt(1 - r * r);
  ByCorrelation out{};
  for (std::size_t k = 0; k < 3; ++k) {
    const double sine = std::sin(kNodes[k] * end);
    out.value += kWeights[k] * std::exp(-(a * a + b * b - 2 * a * b * sine) / (2 * (1 - sine * sine)));
  }
  out.value *= end / (2 * std::numbers::pi);
  out.by_a = density(a) * (phi((b - r * a) / rest) - phi(b));
  out.by_b = density(b) * (phi((a - r * b) / rest) - phi(a));
  out.by_r = std::exp(-(a * a + b * b - 2 * r * a * b) / (2 * rest * rest)) / (2 * std::numbers::pi * rest);
  return out;
}

int first_cell(double s, double sigma, int side) {
  return int(std::clamp(std::floor(s - kFar * sigma), -1.0, side * 1.0));
}
int last_cell(double s, double sigma, int side) {
  return int(std::clamp(std::floor(s + kFar * sigma), -1.0, side * 1.0));
}

// The part of the correlation: of each corner at which four cells meet that are not two and two alike.
void add_correlation(const TagCells& cells, const Vector2d& s, const Vector2d& sigma, double r, const CellShares& u,
                     const CellShares& v, Light& light) {
  for (int j = v.first; j + 1 < v.first + v.count; ++j)
    for (int i = u.first; i + 1 < u.first + u.count; ++i) {
      const double corner = cells.at(i, j) - cells.at(i + 1, j) - cells.at(i, j + 1) + cells.at(i + 1, j + 1);
      if (corner == 0) continue;
      const double a = (i + 1 - s.x()) / sigma.x(), b = (j + 1 - s.y()) / sigma.y();
      const ByCorrelation part = by_correlation(a, b, r);
      light.value += corner * part.value;
      light.by_position -= corner * Vector2d(part.by_a / sigma.x(), part.by_b / sigma.y());
      light.by_log_sigma -= corner * Vector2d(part.by_a * a, part.by_b * b);
      light.by_correlation += corner * part.by_r;
    }
}

Light light_at(const TagCells& cells, const Vector2d& s, const Vector2d& sigma, double correlation) {
  Light out;
  const int x0 = first_cell(s.x(), sigma.x(), cells.side), x1 = last_cell(s.x(), sigma.x(), cells.side);
  const int y0 = first_cell(s.y(), sigma.y(), cells.side), y1 = last_cell(s.y(), sigma.y(), cells.side);
  out.value = cells.at(x0, y0);
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) out.is_flat &= cells.at(x, y) == out.value;
  if (out.is_flat) return out;
  const CellShares u = cell_shares(s.x(), sigma.x(), cells.side), v = cell_shares(s.y(), sigma.y(), cells.side);
  out.value = 0;
  for (int j = 0; j < v.count; ++j) {
    double value = 0, by_position = 0, by_sigma = 0;
    for (int i = 0; i < u.count; ++i) {
      const double light = cells.at(u.first + i, v.first + j);
      value += u.share[std::size_t(i)] * light;
      by_position += u.by_position[std::size_t(i)] * light;
      by_sigma += u.by_log_sigma[std::size_t(i)] * light;
    }
    out.value += v.share[std::size_t(j)] * value;
    out.by_position += Vector2d(v.share[std::size_t(j)] * by_position, v.by_position[std::size_t(j)] * value);
    out.by_log_sigma += Vector2d(v.share[std::size_t(j)] * by_sigma, v.by_log_sigma[std::size_t(j)] * value);
  }
  add_correlation(cells, s, sigma, correlation, u, v, out);
  return out;
}

// Derivatives after blur, centre, A and g. With dq = M^-1 (dd - dM q) and dw = dg' q + g' dq, what light changes by is
// linear in dq, dM and dg: by p' dq + G : dM + (L / w) q' dg, L the sum of the derivatives after the logarithms.
void add_shape(const Local& l, const Light& light, int side, double contrast, double blur, double* derivatives) {
  const Matrix2d& m = l.m;
  const double both = light.by_log_sigma.sum(), u2 = m(1, 1) * m(1, 1) + m(0, 1) * m(0, 1),
               v2 = m(1, 0) * m(1, 0) + m(0, 0) * m(0, 0), uv = std::sqrt(u2 * v2);
  Matrix2d of_u, of_v, of_cosine;  // derivatives of log |u|, log |v| and of u . v, the gradients times det / w
  of_u << 0, m(0, 1) / u2, 0, m(1, 1) / u2;
  of_v << m(0, 0) / v2, 0, m(1, 0) / v2, 0;
  of_cosine << -m(0, 1), -m(0, 0), -m(1, 1), -m(1, 0);
  const Matrix2d by_m = -both * l.inverse.transpose() + light.by_log_sigma.x() * of_u + light.by_log_sigma.y() * of_v +
                        light.by_correlation * (of_cosine / uv - l.cosine() * (of_u + of_v));
  const Vector2d by_q = side * light.by_position + both / l.w * l.g;
  const Vector2d h = l.inverse.transpose() * by_q;
  derivatives[kTagBlur] = contrast * both / blur;
  for (int i = 0; i < 2; ++i) {
    derivatives[i] = contrast * (by_m.row(i).dot(l.g) - l.w * h[i]);
    for (int j = 0; j < 2; ++j) derivatives[kTagShape + 2 * i + j] = contrast * (by_m(i, j) - h[i] * l.q[j]);
    derivatives[kTagShape + 4 + i] = contrast * ((by_q.dot(l.q) + both / l.w) * l.q[i] - by_m.col(i).dot(l.d));
  }
}

}  // namespace

CellShares cell_shares(double s, double sigma, int side) {
  CellShares out;
  out.first = first_cell(s, sigma, side);
  out.count = std::min(last_cell(s, sigma, side) - out.first + 1, int(out.share.size()));
  double below = 0, below_density = 0, below_moment = 0;  // of the border in front of a cell; none before the first
  for (int i = 0; i < out.count; ++i) {
    const double t = (out.first + i + 1 - s) / sigma;
    const bool is_last = i + 1 == out.count;
    const double above = is_last ? 1 : phi(t), d = is_last ? 0 : density(t), moment = d * t;
    out.share[std::size_t(i)] = above - below;
    out.by_position[std::size_t(i)] = (below_density - d) / sigma;
    out.by_log_sigma[std::size_t(i)] = below_moment - (is_last ? 0 : moment);
    below = above, below_density = d, below_moment = moment;
  }
  return out;
}

TagUnknowns tag_unknowns(const TagCorners& c) {
  // The homography of the unit square, in the form that its centre is the origin.
  const Vector2d sum = c[0] - c[1] + c[2] - c[3], d1 = c[1] - c[2], d2 = c[3] - c[2];
  const double denominator = d1.x() * d2.y() - d2.x() * d1.y();
  const double g = (sum.x() * d2.y() - d2.x() * sum.y()) / denominator,
               h = (d1.x() * sum.y() - sum.x() * d1.y()) / denominator;
  Eigen::Matrix3d from_square;
  from_square << c[1].x() - c[0].x() + g * c[1].x(), c[3].x() - c[0].x() + h * c[3].x(), c[0].x(),
      c[1].y() - c[0].y() + g * c[1].y(), c[3].y() - c[0].y() + h * c[3].y(), c[0].y(), g, h, 1;
  Eigen::Matrix3d shift = Eigen::Matrix3d::Identity();
  shift(0, 2) = shift(1, 2) = 0.5;
  Eigen::Matrix3d m = from_square * shift;
  m /= m(2, 2);
  const Vector2d centre = m.block<2, 1>(0, 2), tilt = m.block<1, 2>(2, 0).transpose();
  const Matrix2d axes = m.topLeftCorner<2, 2>() - centre * tilt.transpose();
  TagUnknowns out = TagUnknowns::Zero();
  out.head<2>() = centre;
  out[kTagBlur] = 0.7;
  out.segment<4>(kTagShape) << axes(0, 0), axes(0, 1), axes(1, 0), axes(1, 1);
  out.segment<2>(kTagShape + 4) = tilt;
  return out;
}

Vector2d tag_position(const VectorXd& u, const Vector2d& q, Eigen::Matrix<double, 2, 13>* derivatives) {
  const double w = 1 + tilt_of(u).dot(q);
  const Vector2d from_centre = axes_of(u) * q / w;
  if (derivatives) {
    derivatives->setZero();
    derivatives->leftCols<2>().setIdentity();
    derivatives->block<1, 2>(0, kTagShape) = derivatives->block<1, 2>(1, kTagShape + 2) = q.transpose() / w;
    derivatives->block<2, 2>(0, kTagShape + 4) = -from_centre * q.transpose() / w;
  }
  return u.head<2>() + from_centre;
}

OnTag on_tag(const VectorXd& unknowns, const Vector2d& p) {
  const Local l(unknowns, p);
  return {l.q, l.w > 0 && l.determinant > 0};
}

Vector2d blur_in_cells(const VectorXd& unknowns, const Vector2d& p, int side) {
  return unknowns[kTagBlur] * side * Local(unknowns, p).gradients();
}

bool TagModel::is_possible(const VectorXd& u) const {
  if (!u.allFinite() || !(u[kTagBlur] >= kLeastBlurPx && u[kTagBlur] <= kLargestBlurPx)) return false;
  const Matrix2d axes = axes_of(u), start = axes_of(start_);
  const double size = axes.determinant() / start.determinant();
  if (!(size > 0.5 && size < 2) || !(u[kTagContrast] > 0)) return false;
  if ((u.head<2>() - start_.head<2>()).squaredNorm() > 0.1 * std::abs(start.determinant())) return false;
  return tilt_of(u).cwiseAbs().sum() < 1.6;  // the horizon stays away from the corners
}

double TagModel::grey(const VectorXd& u, const Vector2d& p, double* derivatives) const {
  const Local l(u, p);
  const int side = cells_.side;
  const Vector2d sigma = u[kTagBlur] * side * l.gradients();
  const Light light = light_at(cells_, side * (l.q + Vector2d::Constant(0.5)), sigma, l.cosine());
  const double value =
      u[kTagGround] + u[kTagSlope] * l.d.x() + u[kTagSlope + 1] * l.d.y() + u[kTagContrast] * light.value;
  if (!derivatives) return value;
  std::fill_n(derivatives, kMostUnknowns, 0.0);
  derivatives[kTagGround] = 1;
  derivatives[kTagContrast] = light.value;
  for (int k = 0; k < 2; ++k) derivatives[kTagSlope + k] = l.d[k];
  if (!light.is_flat) add_shape(l, light, side, u[kTagContrast], u[kTagBlur], derivatives);
  for (int k = 0; k < 2; ++k) derivatives[k] -= u[kTagSlope + k];
  return value;
}

}  // namespace collinea
