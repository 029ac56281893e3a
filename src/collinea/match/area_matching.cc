// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/area_matching.h"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "collinea/match/internal/peak_paraboloid.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr double kLeastCorrelation = 0.8;
constexpr int kShiftUnknowns = 4;  // shift, gain, offset
// What is left of less than this is rounding and noise of any image: of two so good ones neither is better.
constexpr double kSmallResidual_grey = 1;  // a pixel
constexpr double kSmallUncorrelated = 0.01;

double residual_of(Similarity method, double value) {
  switch (method) {
    case Similarity::kNcc:
    case Similarity::kCosine:
      return value > 0 ? std::max(0.0, 1 - value * value) : 1;
    case Similarity::kSad:
    case Similarity::kD:
    case Similarity::kDn:
      return value * value;
    default:
      return value;
  }
}

// Whether a value passes the threshold, which counts for a pixel of the template.
bool passes(const CorrelationSurface& surface, double value, std::optional<double> threshold) {
  if (surface.method == Similarity::kNcc) return value >= threshold.value_or(kLeastCorrelation);
  if (!threshold) return true;
  if (surface.method == Similarity::kCosine) return value >= *threshold;
  const double n = surface.pixels;
  switch (surface.method) {
    case Similarity::kSsd:
      return std::sqrt(value / n) <= *threshold;
    case Similarity::kD:
      return value / std::sqrt(n) <= *threshold;
    case Similarity::kDn:
      return value <= *threshold;
    default:
      return value / n <= *threshold;
  }
}

// Noise against grey values makes the first term. Noise against noise, another for each of the nine values, makes the
// second: the gradient of the paraboloid has a sixth of the variance of a value, ssd^2 / n or 0.315 sad^2 / n.
std::optional<Matrix2d> covariance_of(const CorrelationSurface& surface, double least, const Matrix2d& hesse) {
  if (surface.method == Similarity::kRank || surface.method == Similarity::kCensus) return std::nullopt;
  const Matrix2d inverse = hesse.inverse();
  const double n = surface.pixels, left_over = std::max(0.0, least);
  if (surface.method == Similarity::kSad) {
    const double mean = left_over / n;
    return Matrix2d(std::numbers::pi / 2 * mean * inverse + 0.315 / 6 * n * mean * mean * inverse * inverse);
  }
  const double free = std::max(1.0, n - kShiftUnknowns);
  return Matrix2d(2 * left_over / free * inverse + left_over * left_over / (6 * free) * inverse * inverse);
}

Vector2i pixel_of(const Vector2d& position_px) {
  return {static_cast<int>(std::floor(position_px.x())), static_cast<int>(std::floor(position_px.y()))};
}

AreaOptions without_return(AreaOptions options) {
  options.return_px.reset();
  return options;
}

}  // namespace

std::vector<AreaCandidate> candidates(const CorrelationSurface& surface, int radius, std::optional<double> threshold) {
  const FloatImage& values = surface.values;
  const float sign = is_larger_better(surface.method) ? 1 : -1;
  std::vector<AreaCandidate> out;
  for (int y = 0; y < values.height; ++y)
    for (int x = 0; x < values.width; ++x) {
      const float value = sign * values.at(x, y);
      if (!passes(surface, values.at(x, y), threshold)) continue;
      bool is_best = true;
      for (int v = std::max(0, y - radius); is_best && v <= std::min(values.height - 1, y + radius); ++v)
        for (int u = std::max(0, x - radius); is_best && u <= std::min(values.width - 1, x + radius); ++u) {
          const float other = sign * values.at(u, v);
          const bool is_earlier = v < y || (v == y && u < x);
          is_best = is_earlier ? other < value : other <= value;
          if (u == x && v == y) is_best = true;
        }
      if (is_best)
        out.push_back(
            {{surface.left + x, surface.top + y}, values.at(x, y), residual_of(surface.method, values.at(x, y))});
    }
  std::stable_sort(out.begin(), out.end(),
                   [&](const AreaCandidate& a, const AreaCandidate& b) { return sign * a.value > sign * b.value; });
  return out;
}

std::size_t rivals(const CorrelationSurface& surface, std::span<const AreaCandidate> all, double ratio) {
  if (all.size() < 2) return all.size();
  const double n = surface.pixels;
  double least = kSmallResidual_grey * n;
  if (surface.method == Similarity::kNcc) least = kSmallUncorrelated;
  if (surface.method == Similarity::kCosine) {
    const Vector2i at = all[0].pixel - Vector2i(surface.left, surface.top);
    const double norm = surface.deviations.at(at.x(), at.y());
    least /= std::max(norm * norm, least);
  }
  if (surface.method == Similarity::kSad) least *= n;
  if (surface.method == Similarity::kDn) least /= n;
  std::size_t count = 1;
  while (count < all.size() && !(all[count].residual > ratio * std::max(all[0].residual, least))) ++count;
  return count;
}

std::optional<SubpixelPeak> subpixel_peak(const CorrelationSurface& surface, const Vector2i& pixel) {
  const int column = pixel.x() - surface.left, row = pixel.y() - surface.top;
  if (column < 1 || row < 1 || column > surface.values.width - 2 || row > surface.values.height - 2)
    return std::nullopt;
  const PeakParaboloid paraboloid = peak_paraboloid(surface, column, row);
  const auto offset = paraboloid.lowest();
  if (!offset || !(offset->cwiseAbs().maxCoeff() <= 1)) return std::nullopt;
  return SubpixelPeak{*offset, covariance_of(surface, paraboloid.value_at(*offset), paraboloid.hesse)};
}

AreaMatching match_area(const GreyImage& image, const Vector2d& position_px, const GreyImage& other,
                        const Vector2d& expected_px, const AreaOptions& options) {
  AreaMatching out;
  if (!(position_px.cwiseAbs().maxCoeff() < 1e9 && expected_px.cwiseAbs().maxCoeff() < 1e9)) return out;
  const int half = options.template_px / 2, range = std::max(1, (options.search_px - options.template_px) / 2);
  const Vector2i middle = pixel_of(position_px);
  out.surface = correlation_surface(image, middle, half, other, pixel_of(expected_px), range, options.method,
                                    options.neighbourhood_px);
  if (out.surface.values.empty()) return out;
  out.candidates = candidates(out.surface, std::max(2, options.template_px / 4), options.threshold);
  out.outcome = AreaOutcome::kNoCandidate;
  if (out.candidates.empty()) return out;
  out.outcome = AreaOutcome::kAmbiguous;
  if (rivals(out.surface, out.candidates, options.decisive_ratio) > 1) return out;
  out.outcome = AreaOutcome::kAtBorder;
  const AreaCandidate& best = out.candidates.front();
  const auto peak = subpixel_peak(out.surface, best.pixel);
  if (!peak) return out;
  const Vector2d pixel_middle = best.pixel.cast<double>() + Vector2d(0.5, 0.5);
  const Vector2d from_middle = position_px - middle.cast<double>() - Vector2d(0.5, 0.5);
  AreaMatch match{pixel_middle + peak->offset_px + from_middle, peak->covariance_px2, best.value, std::nullopt};
  if (options.return_px) {
    out.outcome = AreaOutcome::kNotReturned;
    const auto back = match_area(other, match.position_px, image, position_px, without_return(options));
    if (!back.match) return out;
    match.returned_px = (back.match->position_px - position_px).norm();
    if (*match.returned_px > *options.return_px) return out;
  }
  out.outcome = AreaOutcome::kFound;
  out.match = match;
  return out;
}

}  // namespace collinea
