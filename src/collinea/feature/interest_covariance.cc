// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/interest_covariance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "collinea/feature/foerstner.h"
#include "collinea/feature/internal/interest_window.h"
#include "collinea/feature/internal/response_paraboloid.h"
#include "collinea/feature/internal/separable_rows.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// Values about a middle pixel, by column and row counted from it.
template <class T>
class Patch {
 public:
  Patch(int half, const T& value)
      : half_(half), values_(std::size_t(2 * half + 1) * std::size_t(2 * half + 1), value) {}
  [[nodiscard]] int half() const { return half_; }
  [[nodiscard]] T& at(int x, int y) {
    return values_[std::size_t(y + half_) * std::size_t(2 * half_ + 1) + std::size_t(x + half_)];
  }
  [[nodiscard]] const T& at(int x, int y) const {
    return values_[std::size_t(y + half_) * std::size_t(2 * half_ + 1) + std::size_t(x + half_)];
  }
  [[nodiscard]] const std::vector<T>& all() const { return values_; }

 private:
  int half_;
  std::vector<T> values_;
};

// The nine responses and, by way of a function, what a change of each does to the pixels.
struct Nine {
  std::array<double, 9> at{};
  static int x(int k) { return k % 3 - 1; }
  static int y(int k) { return k / 3 - 1; }
};

// b_k of the nine responses: how the top moves with each. Nothing where there is no top within a pixel.
std::optional<std::array<Vector2d, 9>> moves_of_top(const Nine& nine) {
  const ResponseParaboloid paraboloid([&](int x, int y) { return nine.at[std::size_t(3 * y + x + 4)]; });
  const auto top = paraboloid.top();
  if (!top) return std::nullopt;
  const Matrix2d inverse = paraboloid.curvature.inverse();
  std::array<Vector2d, 9> out;
  for (int k = 0; k < 9; ++k) {
    const int x = Nine::x(k), y = Nine::y(k);
    out[std::size_t(k)] =
        -inverse * (ResponseParaboloid::by_slope(x, y) + ResponseParaboloid::by_curvature(x, y) * *top);
  }
  return out;
}

Matrix2d sum_of_squares(const Patch<Vector2d>& pixels) {
  Matrix2d out = Matrix2d::Zero();
  for (const Vector2d& g : pixels.all()) out += g * g.transpose();
  return out;
}

// The measure of the tensor (a, c; c, b), and its derivatives by a, c, b.
struct Measure {
  double value = 0;
  Vector3d by = Vector3d::Zero();
};

std::optional<Measure> measure_of(double a, double c, double b, const InterestOptions& o) {
  const double trace = a + b, det = a * b - c * c;
  if (!(trace > 0)) return std::nullopt;
  switch (o.method) {
    case InterestOperator::kHarris:
      return Measure{det - o.harris_k * trace * trace,
                     {b - 2 * o.harris_k * trace, -2 * c, a - 2 * o.harris_k * trace}};
    case InterestOperator::kShiTomasi: {
      const double root = std::hypot(a - b, 2 * c);
      if (!(root > 1e-9 * trace)) return std::nullopt;
      return Measure{(trace - root) / 2, {(1 - (a - b) / root) / 2, -2 * c / root, (1 + (a - b) / root) / 2}};
    }
    default: {  // det / trace
      const double squared = trace * trace;
      return Measure{det / trace, {(b * trace - det) / squared, -2 * c / trace, (a * trace - det) / squared}};
    }
  }
}

// Operators on the structure tensor: from the responses back to the gradients, from these to the pixels.
std::optional<Matrix2d> of_tensor(const GreyImage& image, int column, int row, const InterestOptions& o) {
  const int radius = window_radius(o), reach = radius + 2;
  if (column < reach || row < reach || column + reach >= image.width || row + reach >= image.height)
    return std::nullopt;
  const std::vector<float> taps = gaussian_window(o.sigma_px, radius);
  const bool is_prewitt = o.method == InterestOperator::kKovesi;
  const int lines = is_prewitt ? 1 : 0;  // rows (columns) beside the middle one that the mask adds
  const auto grey = [&](int x, int y) { return double(image.at(column + x, row + y)); };
  Patch<Vector2d> gradients(radius + 1, Vector2d::Zero());
  for (int y = -radius - 1; y <= radius + 1; ++y)
    for (int x = -radius - 1; x <= radius + 1; ++x)
      for (int i = -lines; i <= lines; ++i)
        gradients.at(x, y) +=
            Vector2d(grey(x + 1, y + i) - grey(x - 1, y + i), grey(x + i, y + 1) - grey(x + i, y - 1));
  const auto weight = [&](int x, int y) {
    return double(taps[std::size_t(std::abs(x))]) * taps[std::size_t(std::abs(y))];
  };
  Nine nine;
  std::array<Vector3d, 9> by_tensor;
  for (int k = 0; k < 9; ++k) {
    Vector3d tensor = Vector3d::Zero();  // a, c, b
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x) {
        const Vector2d& g = gradients.at(Nine::x(k) + x, Nine::y(k) + y);
        tensor += weight(x, y) * Vector3d(g.x() * g.x(), g.x() * g.y(), g.y() * g.y());
      }
    const auto measure = measure_of(tensor[0], tensor[1], tensor[2], o);
    if (!measure) return std::nullopt;
    nine.at[std::size_t(k)] = measure->value;
    by_tensor[std::size_t(k)] = measure->by;
  }
  const auto moves = moves_of_top(nine);
  if (!moves) return std::nullopt;
  Patch<Vector2d> pixels(reach, Vector2d::Zero());
  for (int y = -radius - 1; y <= radius + 1; ++y)
    for (int x = -radius - 1; x <= radius + 1; ++x) {
      const Vector2d& g = gradients.at(x, y);
      Vector2d by_gx = Vector2d::Zero(), by_gy = Vector2d::Zero();
      for (int k = 0; k < 9; ++k) {
        const int u = x - Nine::x(k), v = y - Nine::y(k);
        if (std::abs(u) > radius || std::abs(v) > radius) continue;
        const Vector3d& f = by_tensor[std::size_t(k)];
        const Vector2d move = weight(u, v) * (*moves)[std::size_t(k)];
        by_gx += (2 * f[0] * g.x() + f[1] * g.y()) * move;
        by_gy += (2 * f[2] * g.y() + f[1] * g.x()) * move;
      }
      for (int i = -lines; i <= lines; ++i) {
        pixels.at(x + 1, y + i) += by_gx;
        pixels.at(x - 1, y + i) -= by_gx;
        pixels.at(x + i, y + 1) += by_gy;
        pixels.at(x + i, y - 1) -= by_gy;
      }
    }
  return sum_of_squares(pixels);
}

// Laplacian of a Gaussian and difference of Gaussians: one kernel.
std::optional<Matrix2d> of_blob(const GreyImage& image, int column, int row, const InterestOptions& o) {
  const int radius = window_radius(o), reach = radius + 1;
  if (column < reach || row < reach || column + reach >= image.width || row + reach >= image.height)
    return std::nullopt;
  const bool is_log = o.method == InterestOperator::kLog;
  const std::vector<float> fine = gaussian_window(o.sigma_px, radius);
  const std::vector<float> other =
      is_log ? gaussian_curvature(o.sigma_px, radius) : gaussian_window(kDogRatio * o.sigma_px, radius);
  const double factor = is_log ? o.sigma_px * o.sigma_px : 1;
  const auto kernel = [&](int x, int y) {
    const auto i = std::size_t(std::abs(x)), j = std::size_t(std::abs(y));
    if (is_log) return factor * (double(other[i]) * fine[j] + double(fine[i]) * other[j]);
    return double(other[i]) * other[j] - double(fine[i]) * fine[j];
  };
  Nine nine;
  std::array<double, 9> sign{};
  for (int k = 0; k < 9; ++k) {
    double sum = 0;
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x)
        sum += kernel(x, y) * image.at(column + Nine::x(k) + x, row + Nine::y(k) + y);
    nine.at[std::size_t(k)] = std::abs(sum);
    sign[std::size_t(k)] = sum < 0 ? -1 : 1;
  }
  const auto moves = moves_of_top(nine);
  if (!moves) return std::nullopt;
  Patch<Vector2d> pixels(reach, Vector2d::Zero());
  for (int k = 0; k < 9; ++k)
    for (int y = -radius; y <= radius; ++y)
      for (int x = -radius; x <= radius; ++x)
        pixels.at(Nine::x(k) + x, Nine::y(k) + y) += sign[std::size_t(k)] * kernel(x, y) * (*moves)[std::size_t(k)];
  return sum_of_squares(pixels);
}

}  // namespace

std::optional<Matrix2d> paraboloid_covariance(const GreyImage& image, int column, int row,
                                              const InterestOptions& options, double noise_grey) {
  if (options.method == InterestOperator::kMoravec || options.method == InterestOperator::kSift) return std::nullopt;
  const auto squares =
      is_blob(options.method) ? of_blob(image, column, row, options) : of_tensor(image, column, row, options);
  if (!squares) return std::nullopt;
  return Matrix2d(noise_grey * noise_grey * *squares);
}

void add_paraboloid_covariances(const GreyImage& image, const InterestOptions& options, InterestPoints& found) {
  const bool is_any =
      std::any_of(found.points.begin(), found.points.end(), [](const InterestPoint& p) { return p.pixel.has_value(); });
  if (!is_any) return;
  found.noise_grey = options.noise_grey.value_or(noise_of(image));
  for (InterestPoint& point : found.points)
    if (point.pixel && !point.covariance_px2)
      point.covariance_px2 =
          paraboloid_covariance(image, point.pixel->column, point.pixel->row, options, found.noise_grey);
}

}  // namespace collinea
