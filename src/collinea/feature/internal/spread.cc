// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/spread.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "collinea/raster/raster.h"

namespace collinea {
namespace {

constexpr double kSpotsOfRegion = 16;  // wanted on an average

// The count-th strongest, or nothing where there are fewer.
float strength_reached(std::vector<float>& strengths, std::size_t count) {
  if (count == 0 || strengths.size() < count) return 0;
  const auto nth = strengths.begin() + static_cast<std::ptrdiff_t>(count - 1);
  std::ranges::nth_element(strengths, nth, std::ranges::greater{});
  return *nth;
}

}  // namespace

std::vector<float> regional_strengths(std::span<const Spot> spots, int width, int height, int wanted, double evenness,
                                      double least) {
  std::vector<float> strengths;
  for (const Spot& spot : spots) strengths.push_back(spot.strength);
  const auto count = std::min(spots.size(), static_cast<std::size_t>(std::max(0, wanted)));
  std::vector<float> sorted = strengths;
  const float of_image = strength_reached(sorted, count);
  if (!(of_image > 0)) return strengths;

  const double region_px = std::sqrt(double(width) * height * kSpotsOfRegion / static_cast<double>(count));
  FloatImage threshold(std::max(1, static_cast<int>(std::lround(width / region_px))),
                       std::max(1, static_cast<int>(std::lround(height / region_px))));
  const double per_x = double(threshold.width) / width, per_y = double(threshold.height) / height;
  std::vector<std::vector<float>> regions(threshold.data.size());
  for (const Spot& spot : spots) {
    const int column = std::clamp(static_cast<int>(spot.x * per_x), 0, threshold.width - 1);
    const int row = std::clamp(static_cast<int>(spot.y * per_y), 0, threshold.height - 1);
    regions[static_cast<std::size_t>(row * threshold.width + column)].push_back(spot.strength);
  }
  const auto count_of_region =
      static_cast<std::size_t>(std::lround(static_cast<double>(count) / static_cast<double>(regions.size())));
  for (std::size_t r = 0; r < regions.size(); ++r) {
    const float beside_image = strength_reached(regions[r], count_of_region) / of_image;
    threshold.data[r] = std::max(static_cast<float>(least), static_cast<float>(std::pow(beside_image, evenness)));
  }
  for (std::size_t i = 0; i < spots.size(); ++i)
    strengths[i] /= bilinear(threshold, spots[i].x * per_x, spots[i].y * per_y);
  return strengths;
}

}  // namespace collinea
