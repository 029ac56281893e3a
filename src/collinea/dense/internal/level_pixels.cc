// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/level_pixels.h"

#include <algorithm>
#include <utility>

#include "collinea/base/parallel.h"
#include "collinea/feature/texture.h"

namespace collinea {
namespace {

constexpr std::size_t kMostPoints = 2'000'000;
constexpr int kEntropySide_px = 9;

}  // namespace

std::vector<MapPixel> corners_of(const GreyImage& image, double least_threshold, const Run& run) {
  InterestOptions options;
  options.method = InterestOperator::kKovesi;
  options.threshold = least_threshold;
  options.radius_px = 2;
  std::vector<MapPixel> corners = interest_pixels(image, options, run);
  if (corners.size() > kMostPoints) {
    corners.resize(kMostPoints);
    corners.shrink_to_fit();
  }
  return corners;
}

std::vector<Eigen::Vector2i> above(const std::vector<MapPixel>& corners, double threshold) {
  std::vector<Eigen::Vector2i> pixels;
  for (const MapPixel& corner : corners) {
    if (!(corner.value > float(threshold))) break;
    pixels.emplace_back(corner.column, corner.row);
  }
  std::sort(pixels.begin(), pixels.end(),
            [](const auto& a, const auto& b) { return std::pair(a.y(), a.x()) < std::pair(b.y(), b.x()); });
  return pixels;
}

std::vector<Eigen::Vector2i> grid_pixels(const GreyImage& image, int step, double min_entropy, const Run& run) {
  std::vector<std::vector<Eigen::Vector2i>> found(std::size_t(image.height / step + 1));
  parallel_for(run, found.size(), [&](std::size_t i) {
    const int row = step / 2 + int(i) * step;
    if (row >= image.height) return;
    const std::vector<float> entropy = entropy_of_row(image, kEntropySide_px, row);
    for (int column = step / 2; column < image.width; column += step)
      if (image.at(column, row) != 0 && double(entropy[std::size_t(column)]) > min_entropy)
        found[i].emplace_back(column, row);
  });
  std::vector<Eigen::Vector2i> pixels;
  for (const auto& row : found) pixels.insert(pixels.end(), row.begin(), row.end());
  return pixels;
}

}  // namespace collinea
