// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/pull_push.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "collinea/surface/surface_filter.h"

namespace collinea {
namespace {

constexpr double kSteepest = 1;         // rise per run that still is one surface: ground, over the width of a hole
constexpr double kLeastShare = 0.1;     // of the weight, for a level to be believed
constexpr double kDroppedShare = 0.25;  // of the distance to what was left out, in sigma
constexpr double kSigmaPerCell = 0.15;  // of a cell that only coarser ones know, in cells of these

struct Part {
  double height_m, sigma_m, weight;
};

// One surface: a slope, and noise no larger than that, nor than a step.
double tolerance_m(double sigma_m, const HeightLevel& level) {
  const double slope_m = kSteepest * level.cell_m;
  return std::max(level.step_m, slope_m + std::min({3 * sigma_m, slope_m, level.step_m}));
}

// The lowest surface among parts that lie within a cell of the level or two of each other. Sorts them.
Part lowest_surface(std::span<Part> parts, const HeightLevel& level) {
  std::sort(parts.begin(), parts.end(), [](const Part& a, const Part& b) { return a.height_m < b.height_m; });
  double total = 0;
  for (const Part& p : parts) total += p.weight;
  for (std::size_t low = 0;; ++low) {
    const double top_m = parts[low].height_m + tolerance_m(parts[low].sigma_m, level);
    std::size_t end = low;
    double weight = 0;
    for (; end < parts.size() && parts[end].height_m <= top_m; ++end) weight += parts[end].weight;
    if (weight < kLeastShare * total && end < parts.size()) continue;
    Part mean{0, 0, weight};
    for (std::size_t i = low; i < end; ++i) mean.height_m += parts[i].weight / weight * parts[i].height_m;
    double variance = 0;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      const bool used = i >= low && i < end;
      const double off_m = (used ? 1 : kDroppedShare) * (parts[i].height_m - mean.height_m);
      variance += used ? parts[i].weight / weight * (parts[i].sigma_m * parts[i].sigma_m + off_m * off_m)
                       : parts[i].weight / total * off_m * off_m;
    }
    mean.sigma_m = std::sqrt(variance);
    return mean;
  }
}

std::int64_t half(std::int64_t i) { return i >> 1; }

int clamped(std::int64_t i, int size) { return int(std::clamp<std::int64_t>(i, 0, size - 1)); }

// Cells without weight move to the mean of their neighbours; of the known ones only those count that lie on one surface
// with them, so that steps stay at the rims of holes and none are made up inside.
void smooth(HeightLevel& level) {
  const int width = level.height_m.width, height = level.height_m.height;
  const auto most_m = float(tolerance_m(0, level));
  std::vector<float> above, here;  // rows as they were before the round
  for (int round = 0; round < kSmoothings; ++round) {
    for (int y = 0; y < height; ++y) {
      float* const heights = level.height_m.row(y);
      const float* const below = heights + width;  // as it was, too
      const float* const weights = level.weight.row(y);
      std::swap(above, here);
      here.assign(heights, heights + width);
      for (int x = 0; x < width; ++x) {
        if (weights[x] > 0 || here[std::size_t(x)] == kNoHeight) continue;
        const float own = here[std::size_t(x)];
        float sum = 0;
        int count = 0;
        const auto add = [&](float z, float weight) {
          if (weight == 0 || std::abs(z - own) <= most_m) sum += z - own, ++count;
        };
        if (x > 0) add(here[std::size_t(x - 1)], weights[x - 1]);
        if (x + 1 < width) add(here[std::size_t(x + 1)], weights[x + 1]);
        if (y > 0) add(above[std::size_t(x)], weights[x - width]);
        if (y + 1 < height) add(below[x], weights[x + width]);
        if (count > 0) heights[x] = own + sum / float(count);
      }
    }
  }
}

// A level of two by two cells at most: what is unknown there takes the lowest of the others.
void fill_top(HeightLevel& top) {
  std::vector<Part> parts;
  for (std::size_t i = 0; i < top.weight.data.size(); ++i)
    if (top.weight.data[i] > 0)
      parts.push_back({double(top.height_m.data[i]), double(top.sigma_m.data[i]), double(top.weight.data[i])});
  const Part lowest = lowest_surface(parts, top);
  for (std::size_t i = 0; i < top.weight.data.size(); ++i) {
    if (top.weight.data[i] > 0) continue;
    top.height_m.data[i] = float(lowest.height_m);
    top.sigma_m.data[i] = float(lowest.sigma_m + kSigmaPerCell * top.cell_m);
  }
}

}  // namespace

HeightLevel::HeightLevel(std::int64_t first_column, std::int64_t first_row, int width, int height, double cell,
                         double step)
    : column(first_column),
      row(first_row),
      cell_m(cell),
      step_m(step),
      height_m(width, height, 1, kNoHeight),
      sigma_m(width, height, 1, kNoHeight),
      weight(width, height) {}

HeightLevel level_of(FloatImage heights_m, double cell) {
  HeightLevel level;
  level.cell_m = cell;
  level.height_m = std::move(heights_m);
  level.sigma_m = FloatImage(level.height_m.width, level.height_m.height, 1, kNoHeight);
  level.weight = FloatImage(level.height_m.width, level.height_m.height);
  for (std::size_t i = 0; i < level.height_m.data.size(); ++i) {
    if (std::isnan(level.height_m.data[i])) {
      level.height_m.data[i] = kNoHeight;
      continue;
    }
    level.sigma_m.data[i] = 0;
    level.weight.data[i] = 1;
  }
  return level;
}

HeightLevel coarser(const HeightLevel& fine) {
  const std::int64_t column = half(fine.column), row = half(fine.row);
  HeightLevel result(column, row, int(half(fine.column + fine.weight.width - 1) - column + 1),
                     int(half(fine.row + fine.weight.height - 1) - row + 1), 2 * fine.cell_m, fine.step_m);
  for (int y = 0; y < result.weight.height; ++y) {
    for (int x = 0; x < result.weight.width; ++x) {
      std::array<Part, 4> parts;
      std::size_t count = 0;
      for (int child = 0; child < 4; ++child) {
        const std::int64_t u = 2 * (column + x) + (child & 1) - fine.column,
                           v = 2 * (row + y) + (child >> 1) - fine.row;
        if (u < 0 || v < 0 || u >= fine.weight.width || v >= fine.weight.height) continue;
        const double weight = double(fine.weight.at(int(u), int(v)));
        if (weight > 0)
          parts[count++] = {double(fine.height_m.at(int(u), int(v))), double(fine.sigma_m.at(int(u), int(v))), weight};
      }
      if (count == 0) continue;
      const Part lowest = lowest_surface(std::span(parts).first(count), fine);
      result.height_m.at(x, y) = float(lowest.height_m);
      result.sigma_m.at(x, y) = float(lowest.sigma_m);
      result.weight.at(x, y) = float(lowest.weight);
    }
  }
  return result;
}

void fill_from(const HeightLevel& coarse, HeightLevel& fine) {
  const double blur_m = kSigmaPerCell * coarse.cell_m;
  for (int y = 0; y < fine.weight.height; ++y) {
    const std::int64_t row = fine.row + y, beside = row & 1 ? 1 : -1;
    const int v0 = clamped(half(row) - coarse.row, coarse.weight.height);
    const int v1 = clamped(half(row) + beside - coarse.row, coarse.weight.height);
    for (int x = 0; x < fine.weight.width; ++x) {
      if (fine.weight.at(x, y) > 0) continue;
      const std::int64_t column = fine.column + x;
      const int u0 = clamped(half(column) - coarse.column, coarse.weight.width);
      const int u1 = clamped(half(column) + (column & 1 ? 1 : -1) - coarse.column, coarse.weight.width);
      const auto part = [&](int u, int v, double weight) {
        return Part{double(coarse.height_m.at(u, v)), double(coarse.sigma_m.at(u, v)), weight};
      };
      // The farthest of the four has less than a tenth of the weight: alone it does not decide.
      std::array<Part, 4> parts = {part(u0, v0, 9), part(u1, v0, 3), part(u0, v1, 3), part(u1, v1, 1)};
      const Part lowest = lowest_surface(parts, coarse);
      fine.height_m.at(x, y) = float(lowest.height_m);
      fine.sigma_m.at(x, y) = float(std::sqrt(lowest.sigma_m * lowest.sigma_m + blur_m * blur_m));
    }
  }
  smooth(fine);
}

void fill_all(HeightLevel& finest) {
  if (std::none_of(finest.weight.data.begin(), finest.weight.data.end(), [](float w) { return w > 0; })) return;
  if (finest.weight.width <= 2 && finest.weight.height <= 2) return fill_top(finest);
  HeightLevel next = coarser(finest);
  fill_all(next);
  fill_from(next, finest);
}

FloatImage filled(FloatImage heights_m, double cell_m) {
  HeightLevel level = level_of(std::move(heights_m), cell_m);
  fill_all(level);
  return std::move(level.height_m);
}

}  // namespace collinea
