// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/terrain_contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kContoursOverRelief = 20;
constexpr double kContourBlurCells = 2;  // coarse: contours are to show the land, not the grass
constexpr int kBlurRows = 64;            // blurred together
constexpr double kShortestContour = 20;  // coarse cells around
constexpr double kStrayShare = 0.01;     // of the ground, at either end, says nothing of the relief
constexpr double kContourSigmas = 3;     // of a cell; blurred heights err less: closer lines would cross by chance

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

// Rows [first, end): sums of heights and of cells along rows, then along columns.
void blur_rows(const CoarseTerrain& terrain, int first, int end, FloatImage& blurred) {
  constexpr int kRadius = int(3 * kContourBlurCells);
  std::array<float, 2 * kRadius + 1> weights;
  for (int i = -kRadius; i <= kRadius; ++i)
    weights[std::size_t(i + kRadius)] = float(std::exp(-0.5 * i * i / (kContourBlurCells * kContourBlurCells)));
  const int top = std::max(0, first - kRadius), bottom = std::min(terrain.grid.height, end + kRadius),
            width = terrain.grid.width;
  FloatImage sums(width, bottom - top), counts(width, bottom - top);
  for (int y = top; y < bottom; ++y)
    for (int x = 0; x < width; ++x)
      for (int i = -kRadius; i <= kRadius; ++i) {
        const int from = std::clamp(x + i, 0, width - 1);
        const bool there = terrain.covered.at(from, y) != 0;
        sums.at(x, y - top) += weights[std::size_t(i + kRadius)] * (there ? terrain.height_m.at(from, y) : 0);
        counts.at(x, y - top) += weights[std::size_t(i + kRadius)] * (there ? 1 : 0);
      }
  for (int y = first; y < end; ++y)
    for (int x = 0; x < width; ++x) {
      float sum = 0, count = 0;
      for (int i = -kRadius; i <= kRadius; ++i) {
        const int from = std::clamp(y + i, 0, terrain.grid.height - 1) - top;
        sum += weights[std::size_t(i + kRadius)] * sums.at(x, from);
        count += weights[std::size_t(i + kRadius)] * counts.at(x, from);
      }
      blurred.at(x, y) = terrain.covered.at(x, y) ? sum / count : kNaN;
    }
}

// The means where the surface model has anything, NaN elsewhere, blurred by a Gaussian over their like.
FloatImage blurred_means(const CoarseTerrain& terrain, const Run& run) {
  const int height = terrain.grid.height;
  FloatImage blurred(terrain.grid.width, height);
  parallel_for(run, std::size_t((height + kBlurRows - 1) / kBlurRows), [&](std::size_t band) {
    const int first = int(band) * kBlurRows, end = std::min(first + kBlurRows, height);
    blur_rows(terrain, first, end, blurred);
  });
  return blurred;
}

}  // namespace

double contour_interval_m(const CoarseTerrain& terrain) {
  std::vector<float> heights;
  heights.reserve(std::size_t(std::count(terrain.covered.data.begin(), terrain.covered.data.end(), 1)));
  for (std::size_t i = 0; i < terrain.covered.data.size(); ++i)
    if (terrain.covered.data[i]) heights.push_back(terrain.height_m.data[i]);
  if (heights.empty()) return 0;
  const double highest_m = double(quantile(heights, 1 - kStrayShare)),
               relief_m = highest_m - double(quantile(heights, kStrayShare));
  const double least_m = std::max(relief_m / kContoursOverRelief, kContourSigmas * terrain.usual_sigma_m);
  if (!(least_m > 0)) return 0;
  const double unit_m = std::pow(10.0, std::floor(std::log10(least_m)));
  for (const double times : {1, 2, 5})
    if (times * unit_m >= least_m) return times * unit_m;
  return 10 * unit_m;
}

Result<std::size_t> draw_terrain_contours(CoarseTerrain terrain, double interval_m, const std::filesystem::path& file,
                                          const std::filesystem::path& drawing, const Run& run) {
  FloatImage means = blurred_means(terrain, run);
  if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
  const MapGrid grid = std::move(terrain.grid);
  terrain = {};  // makes way for the lines
  return write_contours(std::move(means), grid, interval_m, kShortestContour * grid.cell_m, file, drawing);
}

}  // namespace collinea
