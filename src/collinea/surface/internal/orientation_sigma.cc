// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/orientation_sigma.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "collinea/surface/surface_filter.h"

namespace collinea {
namespace {

constexpr int kLattice = 48;         // steps along the longer side: several for each image of a large block
constexpr std::size_t kNearest = 8;  // positions

double variance_at(std::span<const PositionSigma> position_sigmas, double x, double y, double least2_m2,
                   std::vector<std::pair<double, std::size_t>>& by_distance) {
  by_distance.clear();
  for (std::size_t i = 0; i < position_sigmas.size(); ++i)
    by_distance.emplace_back(std::pow(position_sigmas[i].x - x, 2) + std::pow(position_sigmas[i].y - y, 2), i);
  const auto end = by_distance.begin() + std::ptrdiff_t(std::min(kNearest, by_distance.size()));
  std::partial_sort(by_distance.begin(), end, by_distance.end());
  double sum = 0, weights = 0;
  for (auto it = by_distance.begin(); it != end; ++it) {
    const double weight = 1 / std::max(it->first, least2_m2);
    sum += weight * position_sigmas[it->second].sigma_m * position_sigmas[it->second].sigma_m;
    weights += weight;
  }
  return sum / weights;
}

}  // namespace

OrientationSigma::OrientationSigma(std::span<const PositionSigma> position_sigmas, const CellWindow& raster,
                                   double cell_m)
    : raster_(raster) {
  if (position_sigmas.empty()) return;
  step_ = std::max(1.0, double(std::max(raster.width, raster.height)) / kLattice);
  variance_ = FloatImage(int(std::ceil(raster.width / step_)) + 1, int(std::ceil(raster.height / step_)) + 1);
  std::vector<std::pair<double, std::size_t>> by_distance;
  for (int j = 0; j < variance_.height; ++j)
    for (int i = 0; i < variance_.width; ++i)
      variance_.at(i, j) = float(variance_at(position_sigmas, (double(raster.column) + i * step_) * cell_m,
                                             -(double(raster.row) + j * step_) * cell_m, cell_m * cell_m, by_distance));
}

void OrientationSigma::add_to(FloatImage& sigma_m, const CellWindow& window) const {
  if (variance_.empty()) return;
  for (int y = 0; y < window.height; ++y)
    for (int x = 0; x < window.width; ++x) {
      float& sigma = sigma_m.at(x, y);
      if (sigma == kNoHeight) continue;
      const double u = (double(window.column - raster_.column) + x + 0.5) / step_,
                   v = (double(window.row - raster_.row) + y + 0.5) / step_;
      sigma = std::sqrt(sigma * sigma + bilinear(variance_, u + 0.5, v + 0.5));  // nodes are centres of pixels
    }
}

}  // namespace collinea
