// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/rank_covariance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/match/internal/peak_paraboloid.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector2i;

constexpr int kTrials = 64;
constexpr double kRounding_grey = 0.288675134594813;  // 1 / sqrt(12)
constexpr int kUnknowns = 4;                          // shift, gain, offset

// What lies `half` pixels about one; beyond the border the nearest pixel, as rank and census count it.
GreyImage cut(const GreyImage& image, const Vector2i& middle, int half) {
  GreyImage out(2 * half + 1, 2 * half + 1);
  for (int y = -half; y <= half; ++y)
    for (int x = -half; x <= half; ++x)
      out.at(x + half, y + half) =
          image.at(std::clamp(middle.x() + x, 0, image.width - 1), std::clamp(middle.y() + y, 0, image.height - 1));
  return out;
}

void add_noise(const GreyImage& image, double noise_grey, Random& random, GreyImage& out) {
  for (std::size_t i = 0; i < image.data.size(); ++i)
    out.data[i] = std::uint8_t(std::clamp(std::lround(image.data[i] + noise_grey * random.normal()), 0L, 255L));
}

// By the paraboloid of what gain and offset of the template leave unexplained: its least value is 2 (n - 4) s^2.
std::optional<double> noise_of_pair(const GreyImage& image, const Vector2i& middle, int half, const GreyImage& other,
                                    const Vector2i& pixel) {
  const CorrelationSurface surface = correlation_surface(image, middle, half, other, pixel, 1, Similarity::kNcc);
  if (surface.values.width != 3 || surface.values.height != 3) return std::nullopt;
  const PeakParaboloid paraboloid = peak_paraboloid(surface, 1, 1);
  const auto lowest = paraboloid.lowest();
  const double least = lowest ? paraboloid.value_at(*lowest) : paraboloid.middle;
  const double free = std::max(1.0, double(surface.pixels - kUnknowns));
  return std::max(std::sqrt(std::max(least, 0.0) / (2 * free)), kRounding_grey);
}

}  // namespace

std::optional<Matrix2d> rank_covariance(const GreyImage& image, const Vector2i& middle, int half,
                                        const GreyImage& other, const Vector2i& pixel, Similarity method,
                                        int neighbourhood_px) {
  if (method != Similarity::kRank && method != Similarity::kCensus) return std::nullopt;
  const auto noise_grey = noise_of_pair(image, middle, half, other, pixel);
  if (!noise_grey) return std::nullopt;
  const int reach = half + neighbourhood_px / 2;
  const GreyImage pattern = cut(image, middle, reach), searched = cut(other, pixel, reach + 1);
  GreyImage noisy_pattern(pattern.width, pattern.height), noisy_searched(searched.width, searched.height);
  Random random(1, 0);
  std::vector<Vector2d> positions;
  Vector2d mean = Vector2d::Zero();
  for (int trial = 0; trial < kTrials; ++trial) {
    add_noise(pattern, *noise_grey, random, noisy_pattern);
    add_noise(searched, *noise_grey, random, noisy_searched);
    const CorrelationSurface surface = correlation_surface(noisy_pattern, {reach, reach}, half, noisy_searched,
                                                           {reach + 1, reach + 1}, 1, method, neighbourhood_px);
    const auto peak = subpixel_peak(surface, {reach + 1, reach + 1});
    if (!peak) continue;
    positions.push_back(peak->offset_px);
    mean += peak->offset_px;
  }
  if (4 * positions.size() < 3 * std::size_t(kTrials)) return std::nullopt;
  const double count = double(positions.size());
  mean /= count;
  Matrix2d covariance = Matrix2d::Zero();
  for (const Vector2d& at : positions) covariance += (at - mean) * (at - mean).transpose();
  // E of the inverse of a covariance by n is (n - 1) / (n - 4) of the inverse (Wishart, two dimensions).
  return Matrix2d(covariance / (count - 4));
}

void add_rank_covariance(const GreyImage& image, const Vector2d& position_px, const GreyImage& other,
                         const AreaOptions& options, AreaMatching& matching) {
  if (!matching.match || matching.match->covariance_px2) return;
  const Vector2i middle = position_px.array().floor().matrix().cast<int>();
  matching.match->covariance_px2 =
      rank_covariance(image, middle, options.template_px / 2, other, matching.candidates.front().pixel, options.method,
                      options.neighbourhood_px);
}

}  // namespace collinea
