// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/window_equations.h"

#include <Eigen/LU>
#include <cmath>

namespace collinea {
namespace {

constexpr double kWeightOfHalf = 0.6;  // standard deviation of the weight function, of the half width

double squared_norm(const std::array<double, 4>& weights) {
  return weights[0] * weights[0] + weights[1] * weights[1] + weights[2] * weights[2] + weights[3] * weights[3];
}
// Variance of a smoothed grey value for white noise of 1.
double white_part(const SplineSample& sample) { return squared_norm(sample.across) * squared_norm(sample.down); }

}  // namespace

std::optional<ReferenceTemplate> ReferenceTemplate::of(const GreyImage& image, const Eigen::Vector2d& at,
                                                       int window_px) {
  if (!(std::abs(at.x()) < 1e7 && std::abs(at.y()) < 1e7)) return std::nullopt;
  ReferenceTemplate out;
  const int half = window_px / 2;
  const int column = static_cast<int>(std::floor(at.x())), row = static_cast<int>(std::floor(at.y()));
  double sum = 0;
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x) {
      const Eigen::Vector2d pixel(column + x + 0.5, row + y + 0.5);
      const auto sample = spline_sample(image, pixel);
      if (!sample) return std::nullopt;
      const double square = double(x * x + y * y) / double(half * half);
      const double weight = std::exp(-0.5 * square / (kWeightOfHalf * kWeightOfHalf));
      out.points.push_back({*sample, pixel - at, weight});
      out.weights += weight;
      sum += weight * sample->grey;
    }
  for (Point& point : out.points) point.sample.grey -= sum / out.weights;
  out.left = out.points.front().sample.left;
  out.top = out.points.front().sample.top;
  out.side = window_px + 3;
  return out;
}

std::optional<WindowEquations> window_equations(const ReferenceTemplate& reference, const GreyImage& image,
                                                const WindowState& state, const MapPrior& prior) {
  if (!(std::abs(state.map.determinant()) > 1e-6)) return std::nullopt;
  WindowEquations out;
  out.matrix.setZero();
  out.right.setZero();
  const Eigen::Matrix2d slope_here = state.gain * state.map.inverse().transpose();
  double sum = 0, square = 0, common = 0, reference_square = 0;
  for (std::size_t k = 0; k < reference.points.size(); ++k) {
    const ReferenceTemplate::Point& point = reference.points[k];
    const auto sample = spline_sample(image, state.position(reference, k));
    if (!sample) return std::nullopt;
    const double u = point.offset.x(), v = point.offset.y(), grey = point.sample.grey;
    const auto derivatives = [&](const Eigen::Vector2d& slope) {
      WindowVector d;
      d << slope.x(), slope.y(), slope.x() * u, slope.x() * v, slope.y() * u, slope.y() * v, -grey, -1;
      return d;
    };
    const double left_over = sample->grey - state.gain * grey - state.offset_grey;
    const WindowVector instrument = point.weight * derivatives(slope_here * point.sample.slope);
    out.matrix.noalias() += instrument * derivatives(sample->slope).transpose();
    out.right -= left_over * instrument;
    out.squares += point.weight * left_over * left_over;
    out.white += point.weight * (white_part(*sample) + state.gain * state.gain * white_part(point.sample));
    out.by_point.push_back(instrument);
    out.samples.push_back(*sample);
    sum += point.weight * sample->grey;
    square += point.weight * sample->grey * sample->grey;
    common += point.weight * sample->grey * grey;
    reference_square += point.weight * grey * grey;
  }
  const Eigen::Matrix2d known = prior.map - state.map;
  out.matrix.diagonal().segment<4>(2).array() += prior.weight;
  out.right.segment<4>(2) += prior.weight * Eigen::Vector4d(known(0, 0), known(0, 1), known(1, 0), known(1, 1));
  const double variance = square - sum * sum / reference.weights;
  if (variance > 0 && reference_square > 0) out.correlation = common / std::sqrt(variance * reference_square);
  return out;
}

BlockMeans block_means(const ReferenceTemplate& reference, const WindowEquations& equations, const WindowState& state) {
  constexpr int kSide = BlockMeans::kSide;
  // Variance of the mean of three neighbours that a spline on the pixels has smoothed, along one axis: the squares of
  // (1, 5, 6, 5, 1) / 18; of all nine their square.
  constexpr double kAlongOne = 88.0 / 324;
  const int side = reference.side - 3;
  BlockMeans out;
  for (int top = 0; top + kSide <= side; top += kSide)
    for (int left = 0; left + kSide <= side; left += kSide) {
      double sum = 0, weight = 0;
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const auto k = std::size_t((top + y) * side + left + x);
          const ReferenceTemplate::Point& point = reference.points[k];
          sum += equations.samples[k].grey - state.gain * point.sample.grey - state.offset_grey;
          weight += point.weight;
        }
      const double mean = sum / (kSide * kSide);
      out.squares += weight * mean * mean;
      out.white += weight * (1 + state.gain * state.gain) * kAlongOne * kAlongOne;
    }
  return out;
}

std::optional<double> window_correlation(const ReferenceTemplate& reference, const GreyImage& image,
                                         const Eigen::Vector2d& pixel, const Eigen::Matrix2d& map, int step) {
  const std::size_t side = std::size_t(reference.side - 3), stride = std::size_t(step);
  double weights = 0, sum = 0, sum_reference = 0, square = 0, square_reference = 0, common = 0;
  for (std::size_t y = 0; y < side; y += stride)
    for (std::size_t x = 0; x < side; x += stride) {
      const ReferenceTemplate::Point& point = reference.points[y * side + x];
      const auto sample = spline_sample(image, pixel + map * point.offset);
      if (!sample) return std::nullopt;
      const double a = point.sample.grey, b = sample->grey, w = point.weight;
      weights += w;
      sum_reference += w * a;
      sum += w * b;
      square_reference += w * a * a;
      square += w * b * b;
      common += w * a * b;
    }
  const double variance = square - sum * sum / weights,
               of_reference = square_reference - sum_reference * sum_reference / weights;
  if (!(variance > 1e-9 && of_reference > 1e-9)) return 0;
  return (common - sum * sum_reference / weights) / std::sqrt(variance * of_reference);
}

}  // namespace collinea
