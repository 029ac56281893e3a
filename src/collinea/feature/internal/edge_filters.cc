// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/edge_filters.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

EdgeMask transposed(const EdgeMask& m) { return {m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]}; }

// The outer ring by one step, anticlockwise as the image is seen: 45 degrees.
EdgeMask turned(const EdgeMask& m) {
  constexpr int ring[] = {0, 1, 2, 5, 8, 7, 6, 3};
  EdgeMask out = m;
  for (int i = 0; i < 8; ++i) out[std::size_t(ring[i])] = m[std::size_t(ring[(i + 1) % 8])];
  return out;
}

double response_to_x(const EdgeMask& m) {
  double sum = 0;
  for (int i = 0; i < 9; ++i) sum += m[std::size_t(i)] * (i % 3 - 1);
  return sum;
}

double response_to_y(const EdgeMask& m) { return response_to_x(transposed(m)); }

bool is_compass(EdgeOperator of) {
  return of == EdgeOperator::kPrewittCompass || of == EdgeOperator::kKirsch || of == EdgeOperator::kRobinson3 ||
         of == EdgeOperator::kRobinson5;
}

EdgeMask first_of_compass(EdgeOperator of) {
  if (of == EdgeOperator::kPrewittCompass) return {1, 1, 1, 1, -2, 1, -1, -1, -1};
  if (of == EdgeOperator::kKirsch) return {5, 5, 5, -3, 0, -3, -3, -3, -3};
  if (of == EdgeOperator::kRobinson3) return {1, 1, 1, 0, 0, 0, -1, -1, -1};
  return {1, 2, 1, 0, 0, 0, -1, -2, -1};
}

EdgeMask across_of(double middle) { return {-1, 0, 1, -middle, 0, middle, -1, 0, 1}; }

EdgeMask scaled(EdgeMask m, double by) {
  for (double& w : m) w *= by;
  return m;
}

// Pseudo-inverse of the monomials x^i y^j with i + j <= degree over a square window.
Eigen::MatrixXd monomial_fit(int degree, int half) {
  const int side = 2 * half + 1, terms = (degree + 1) * (degree + 2) / 2;
  Eigen::MatrixXd a(side * side, terms);
  for (int p = 0; p < side * side; ++p) {
    const double x = p % side - half, y = p / side - half;
    int k = 0;
    for (int total = 0; total <= degree; ++total)
      for (int j = 0; j <= total; ++j) a(p, k++) = std::pow(x, total - j) * std::pow(y, j);
  }
  return (a.transpose() * a).ldlt().solve(a.transpose());
}

}  // namespace

std::vector<EdgeMask> edge_masks(EdgeOperator of) {
  switch (of) {
    case EdgeOperator::kRoberts:
      return {{0, 1, 0, -1, 0, 0, 0, 0, 0}, {1, 0, 0, 0, -1, 0, 0, 0, 0}};
    case EdgeOperator::kPrewitt:
      return {across_of(1), transposed(across_of(1))};
    case EdgeOperator::kSobel:
      return {across_of(2), transposed(across_of(2))};
    case EdgeOperator::kIsotropic:
      return {across_of(std::numbers::sqrt2), transposed(across_of(std::numbers::sqrt2))};
    case EdgeOperator::kLog:
    case EdgeOperator::kHaralick:
      return {};
    default:
      break;
  }
  std::vector<EdgeMask> masks{first_of_compass(of)};
  while (masks.size() < 8) masks.push_back(turned(masks.back()));
  return masks;
}

std::vector<double> gaussian_kernel(double sigma_px, int derivative) {
  const int radius = int(std::ceil(4 * sigma_px));
  std::vector<double> g(std::size_t(2 * radius + 1));
  for (int i = -radius; i <= radius; ++i) {
    const double u = i / sigma_px, bell = std::exp(-u * u / 2);
    g[std::size_t(i + radius)] = derivative == 0 ? bell : derivative == 1 ? u * bell : (u * u - 1) * bell;
  }
  double mean = 0;
  for (const double w : g) mean += w / double(g.size());
  double scale = 0;
  for (int i = -radius; i <= radius; ++i) {
    double& w = g[std::size_t(i + radius)];
    if (derivative == 2) w -= mean;  // nothing on uniform areas
    scale += derivative == 0 ? w : derivative == 1 ? w * i : w * i * i / 2;
  }
  for (double& w : g) w /= scale;
  return g;
}

FloatImage separable(const FloatImage& image, const std::vector<double>& across, const std::vector<double>& down) {
  const int w = image.width, h = image.height, ra = int(across.size() / 2), rd = int(down.size() / 2);
  FloatImage rows(w, h), out(w, h);
  std::vector<float> line(std::size_t(w + 2 * ra));
  for (int y = 0; y < h; ++y) {
    for (int x = -ra; x < w + ra; ++x) line[std::size_t(x + ra)] = image.at(std::clamp(x, 0, w - 1), y);
    float* to = rows.row(y);
    for (std::size_t k = 0; k < across.size(); ++k) {
      const float weight = float(across[k]);
      const float* from = line.data() + k;
      for (int x = 0; x < w; ++x) to[x] += weight * from[x];
    }
  }
  for (int y = 0; y < h; ++y) {
    float* to = out.row(y);
    for (int k = -rd; k <= rd; ++k) {
      const float weight = float(down[std::size_t(k + rd)]);
      const float* from = rows.row(std::clamp(y + k, 0, h - 1));
      for (int x = 0; x < w; ++x) to[x] += weight * from[x];
    }
  }
  return out;
}

GradientMasks gradient_masks(EdgeOperator of) {
  if (of == EdgeOperator::kRoberts)  // of the corner between the four pixels at the lower right
    return {{0, 0, 0, 0, -0.5, 0.5, 0, -0.5, 0.5}, {0, 0, 0, 0, -0.5, -0.5, 0, 0.5, 0.5}, 0.5};
  if (is_compass(of)) {
    GradientMasks sum;
    for (const EdgeMask& mask : edge_masks(of)) {
      const double x = response_to_x(mask), y = response_to_y(mask), n = std::hypot(x, y);
      for (std::size_t i = 0; i < 9; ++i) {
        sum.x[i] += mask[i] * x / n;
        sum.y[i] += mask[i] * y / n;
      }
    }
    return {scaled(sum.x, 1 / response_to_x(sum.x)), scaled(sum.y, 1 / response_to_y(sum.y)), 0};
  }
  const double middle = of == EdgeOperator::kPrewitt ? 1 : of == EdgeOperator::kIsotropic ? std::numbers::sqrt2 : 2;
  const EdgeMask x = scaled(across_of(middle), 1 / (4 + 2 * middle));
  return {x, transposed(x), 0};
}

double compass_scale(EdgeOperator of) { return is_compass(of) ? std::abs(response_to_y(first_of_compass(of))) : 1; }

SmoothedNoise::SmoothedNoise(double sigma_px) {
  at_[0] = 1;
  if (!(sigma_px > 0.05)) return;
  const std::vector<double> g = gaussian_kernel(sigma_px, 0);
  for (std::size_t lag = 0; lag < at_.size(); ++lag) {
    at_[lag] = 0;
    for (std::size_t i = 0; i + lag < g.size(); ++i) at_[lag] += g[i] * g[i + lag];
  }
}

double SmoothedNoise::covariance(const Weights5& weights, int down) const {
  Weights5 across{};  // the second sum, with the factors along rows
  for (int y = 0; y < 5; ++y)
    for (int x = 0; x < 5; ++x)
      for (int x2 = 0; x2 < 5; ++x2)
        across[std::size_t(5 * y + x)] += weights[std::size_t(5 * y + x2)] * at_[std::size_t(std::abs(x - x2))];
  double sum = 0;
  for (int y = 0; y < 5; ++y)
    for (int y2 = 0; y2 < 5; ++y2) {
      const int lag = std::abs(y - y2 - down);
      if (lag >= int(at_.size())) continue;
      for (int x = 0; x < 5; ++x)
        sum += weights[std::size_t(5 * y + x)] * across[std::size_t(5 * y2 + x)] * at_[std::size_t(lag)];
    }
  return sum;
}

double SmoothedNoise::variance(const EdgeMask& mask) const {
  Weights5 wide{};
  for (int i = 0; i < 9; ++i) wide[std::size_t(5 * (i / 3 + 1) + i % 3 + 1)] = mask[std::size_t(i)];
  return covariance(wide);
}

const std::array<Weights5, 10>& facet_weights() {
  static const auto weights = [] {
    const Eigen::MatrixXd fit = monomial_fit(3, 2);
    std::array<Weights5, 10> out;
    for (int k = 0; k < 10; ++k)
      for (int p = 0; p < 25; ++p) out[std::size_t(k)][std::size_t(p)] = fit(k, p);
    return out;
  }();
  return weights;
}

const std::array<EdgeMask, 6>& paraboloid_weights() {
  static const auto weights = [] {
    const Eigen::MatrixXd fit = monomial_fit(2, 1);
    std::array<EdgeMask, 6> out;
    for (int k = 0; k < 6; ++k)
      for (int p = 0; p < 9; ++p) out[std::size_t(k)][std::size_t(p)] = fit(k, p);
    return out;
  }();
  return weights;
}

}  // namespace collinea
