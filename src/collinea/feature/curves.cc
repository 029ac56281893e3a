// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/curves.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Vector2d;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr int kStepX[] = {1, 1, 0, -1, -1, -1, 0, 1}, kStepY[] = {0, -1, -1, -1, 0, 1, 1, 1};

double distance_from(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
  const Vector2d d = b - a;
  const double t = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0;
  return (p - a - t * d).norm();
}

// Marks the points between two kept ones that a polygon needs.
void keep_between(std::span<const Vector2d> curve, std::size_t first, std::size_t last, double tolerance_px,
                  std::vector<char>& is_kept) {
  std::vector<std::pair<std::size_t, std::size_t>> open{{first, last}};
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    double farthest = tolerance_px;
    std::size_t at = a;
    for (std::size_t i = a + 1; i < b; ++i)
      if (const double d = distance_from(curve[i], curve[a], curve[b % curve.size()]); d > farthest) {
        farthest = d;
        at = i;
      }
    if (at == a) continue;
    is_kept[at] = 1;
    open.emplace_back(a, at);
    open.emplace_back(at, b);
  }
}

// Radix-2, in place; `sign` -1 forwards.
void fourier(std::vector<std::complex<double>>& z, double sign) {
  const std::size_t n = z.size();
  for (std::size_t i = 1, j = 0; i < n; ++i) {
    std::size_t bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(z[i], z[j]);
  }
  for (std::size_t length = 2; length <= n; length <<= 1)
    for (std::size_t i = 0; i < n; i += length)
      for (std::size_t k = 0; k < length / 2; ++k) {
        const auto w = std::polar(1.0, sign * kTurn * double(k) / double(length)) * z[i + k + length / 2];
        z[i + k + length / 2] = z[i + k] - w;
        z[i + k] += w;
      }
}

// A parabola across the chord of some neighbours of a point, whose numbers these are: direction and curvature there.
PsiS local_shape(std::span<const Vector2d> curve, const std::vector<std::size_t>& near, const Vector2d& at,
                 const AcrossCovariance& covariance) {
  const Vector2d along = (curve[near.back()] - curve[near.front()]).normalized(), across(-along.y(), along.x());
  Eigen::MatrixXd a(Eigen::Index(near.size()), 3);
  Eigen::VectorXd v(a.rows());
  for (std::size_t i = 0; i < near.size(); ++i) {
    const double u = along.dot(curve[near[i]] - at);
    a.row(Eigen::Index(i)) << 1, u, u * u;
    v[Eigen::Index(i)] = across.dot(curve[near[i]] - at);
  }
  const Eigen::Matrix3d inverse = (a.transpose() * a).inverse();
  const Eigen::Vector3d c = inverse * (a.transpose() * v);
  Eigen::Matrix3d spread = inverse;
  if (covariance) {
    Eigen::MatrixXd errors(a.rows(), a.rows());
    for (Eigen::Index i = 0; i < a.rows(); ++i)
      for (Eigen::Index k = 0; k < a.rows(); ++k) errors(i, k) = covariance(near[std::size_t(i)], near[std::size_t(k)]);
    spread = inverse * (a.transpose() * errors * a) * inverse;
  }
  const double root = 1 + c[1] * c[1];
  PsiS out;
  out.psi_rad = std::atan2(along.y(), along.x()) + std::atan(c[1]);
  out.curvature_per_px = 2 * c[2] / std::pow(root, 1.5);
  out.sigma_curvature = 2 * std::sqrt(std::max(0.0, spread(2, 2))) / std::pow(root, 1.5);
  out.sigma_psi_rad = std::sqrt(std::max(0.0, spread(1, 1))) / root;
  return out;
}

}  // namespace

double length_of(std::span<const Vector2d> curve, bool is_closed) {
  double sum = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) sum += (curve[i] - curve[i - 1]).norm();
  return is_closed && curve.size() > 1 ? sum + (curve.front() - curve.back()).norm() : sum;
}

double area_of(std::span<const Vector2d> curve) {
  double sum = 0;
  for (std::size_t i = 0; i < curve.size(); ++i) {
    const Vector2d &a = curve[i], &b = curve[(i + 1) % curve.size()];
    sum += a.x() * b.y() - b.x() * a.y();
  }
  return sum / 2;
}

Curve resampled(std::span<const Vector2d> curve, bool is_closed, int count) {
  const double length = length_of(curve, is_closed);
  if (!(length > 0) || count < 2) return {};
  Curve out;
  const double step = length / (is_closed ? count : count - 1);
  double before = 0;  // length up to point i
  std::size_t i = 0;
  const auto piece = [&] { return (curve[(i + 1) % curve.size()] - curve[i]).norm(); };
  for (int k = 0; k < count; ++k) {
    const double s = k * step;
    const std::size_t pieces = is_closed ? curve.size() : curve.size() - 1;
    while (i + 1 < pieces && before + piece() < s) before += piece(), ++i;
    const double t = piece() > 0 ? std::clamp((s - before) / piece(), 0.0, 1.0) : 0;
    out.push_back((1 - t) * curve[i] + t * curve[(i + 1) % curve.size()]);
  }
  return out;
}

Curve polygon_of(std::span<const Vector2d> curve, bool is_closed, double tolerance_px) {
  const std::size_t n = curve.size();
  if (n < 3) return {curve.begin(), curve.end()};
  std::vector<char> is_kept(n, 0);
  if (is_closed) {
    const auto farthest_from = [&](std::size_t from) {
      std::size_t best = from;
      for (std::size_t i = 0; i < n; ++i)
        if ((curve[i] - curve[from]).norm() > (curve[best] - curve[from]).norm()) best = i;
      return best;
    };
    std::size_t a = farthest_from(0), b = farthest_from(a);
    if (a > b) std::swap(a, b);
    is_kept[a] = is_kept[b] = 1;
    std::vector<Vector2d> from_a(n);  // so that no piece runs over the end
    for (std::size_t i = 0; i < n; ++i) from_a[i] = curve[(a + i) % n];
    std::vector<char> turned(n, 0);
    keep_between(from_a, 0, b - a, tolerance_px, turned);
    keep_between(from_a, b - a, n, tolerance_px, turned);
    for (std::size_t i = 0; i < n; ++i)
      if (turned[i]) is_kept[(a + i) % n] = 1;
  } else {
    is_kept.front() = is_kept.back() = 1;
    keep_between(curve, 0, n - 1, tolerance_px, is_kept);
  }
  Curve out;
  for (std::size_t i = 0; i < n; ++i)
    if (is_kept[i]) out.push_back(curve[i]);
  return out;
}

ChainCode chain_code(std::span<const Vector2d> curve, bool is_closed) {
  ChainCode code;
  if (curve.empty()) return code;
  int x = int(std::floor(curve[0].x())), y = int(std::floor(curve[0].y()));
  code.x = x;
  code.y = y;
  for (std::size_t i = 1; i < curve.size() + (is_closed ? 1 : 0); ++i) {
    const Vector2d& p = curve[i % curve.size()];
    const int to_x = int(std::floor(p.x())), to_y = int(std::floor(p.y())), dx = to_x - x, dy = to_y - y;
    const int steps = std::max(std::abs(dx), std::abs(dy)), from_x = x, from_y = y;
    for (int k = 1; k <= steps; ++k) {
      const int next_x = from_x + int(std::lround(double(dx) * k / steps));
      const int next_y = from_y + int(std::lround(double(dy) * k / steps));
      for (int step = 0; step < 8; ++step)
        if (kStepX[step] == next_x - x && kStepY[step] == next_y - y) code.steps.push_back(std::uint8_t(step));
      x = next_x;
      y = next_y;
    }
  }
  return code;
}

Curve curve_of(const ChainCode& code) {
  int x = code.x, y = code.y;
  Curve out{{x + 0.5, y + 0.5}};
  for (const std::uint8_t step : code.steps) {
    x += kStepX[step % 8];
    y += kStepY[step % 8];
    out.emplace_back(x + 0.5, y + 0.5);
  }
  return out;
}

std::vector<PsiS> psi_s(std::span<const Vector2d> curve, bool is_closed, double window_px,
                        const AcrossCovariance& covariance) {
  const int n = int(curve.size());
  if (n < 5) return {};
  std::vector<PsiS> out;
  double s = 0;
  const auto number = [&](int i) { return std::size_t((i % n + n) % n); };
  const auto at = [&](int i) { return curve[number(i)]; };
  // How many points further in one direction: as far as the window reaches, two at least, not beyond an end.
  const auto reach = [&](int from, int sense) {
    int steps = 0;
    for (double length = 0; steps < n / 2; ++steps) {
      const int next = from + sense * (steps + 1);
      if (!is_closed && (next < 0 || next >= n)) break;
      length += (at(next) - at(next - sense)).norm();
      if (length > window_px && steps >= 2) break;
    }
    return steps;
  };
  for (int i = 0; i < n; ++i) {
    if (i > 0) s += (at(i) - at(i - 1)).norm();
    std::vector<std::size_t> near;
    int before = reach(i, -1), behind = reach(i, +1);
    if (before + behind < 2) {
      before = std::min(i, 2);
      behind = std::min(n - 1 - i, 2);
    }
    for (int k = i - before; k <= i + behind; ++k) near.push_back(number(k));
    PsiS point = local_shape(curve, near, at(i), covariance);
    point.s_px = s;
    if (!out.empty()) point.psi_rad = out.back().psi_rad + std::remainder(point.psi_rad - out.back().psi_rad, kTurn);
    out.push_back(point);
  }
  return out;
}

FourierDescriptors fourier_descriptors(std::span<const Vector2d> curve, bool is_closed, int harmonics) {
  if (curve.size() < 3 || harmonics < 1) return {};
  std::size_t n = 64;
  while (n < 8 * std::size_t(harmonics)) n *= 2;
  Curve points;
  if (is_closed) {
    points = resampled(curve, true, int(n));
  } else {
    std::vector<Vector2d> there_and_back(curve.begin(), curve.end());
    for (std::size_t i = curve.size() - 1; i-- > 1;) there_and_back.push_back(curve[i]);
    points = resampled(there_and_back, true, int(n));
  }
  if (points.empty()) return {};
  std::vector<std::complex<double>> z;
  for (const Vector2d& p : points) z.emplace_back(p.x(), p.y());
  fourier(z, -1);
  FourierDescriptors out;
  for (int k = -harmonics; k <= harmonics; ++k) out.at.push_back(z[std::size_t((k + int(n)) % int(n))] / double(n));
  return out;
}

Curve FourierDescriptors::curve(int count) const {
  Curve out;
  for (int k = 0; k < count; ++k) {
    std::complex<double> z = 0;
    for (int n = -harmonics(); n <= harmonics(); ++n) z += (*this)(n)*std::polar(1.0, kTurn * n * k / count);
    out.emplace_back(z.real(), z.imag());
  }
  return out;
}

std::vector<double> FourierDescriptors::invariants() const {
  std::vector<double> out;
  if (at.empty() || !(std::abs((*this)(1)) > 0)) return out;
  for (int n = -harmonics(); n <= harmonics(); ++n)
    if (n != 0 && n != 1) out.push_back(std::abs((*this)(n)) / std::abs((*this)(1)));
  return out;
}

}  // namespace collinea
