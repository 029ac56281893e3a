// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "collinea/base/parallel.h"
#include "collinea/dense/level.h"

namespace collinea::dense {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kTrials = 5;        // depths tried: 0, +-half, +-whole the search
constexpr float kHidden = 0.25f;  // a view this much worse than the best one looks at something else
constexpr float kWindowPixels = float((2 * kRadius + 1) * (2 * kRadius + 1));

struct alignas(64) Trials {
  std::array<std::array<float, kCellPixels>, kTrials> correlation;
};

struct RefineScratch {
  CellScene scene;
  WindowStatistics statistics;
  alignas(64) std::array<float, kRegion> reference, sampled;
  std::vector<Trials> trials;  // by view
};

void reference_region(const GreyImage& picture, int left, int top, float* region) {
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i) {
      const int x = left - kRadius + i, y = top - kRadius + j;
      const bool there = x >= 0 && y >= 0 && x < picture.width && y < picture.height && picture.at(x, y) != 0;
      region[j * kRegionWidth + i] = there ? float(picture.at(x, y)) - 128 : kNaN;
    }
}

// The correlations of one pixel, averaged over the views that show the same thing.
struct Curve {
  std::array<float, kTrials> mean{};
  float views = 0;  // effective number of them
};

std::optional<Curve> curve_of(const RefineScratch& scratch, std::size_t views, std::size_t pixel) {
  std::array<float, 16> best{};
  float best_of_all = 0;
  for (std::size_t v = 0; v < views; ++v) {
    float highest = -1;
    for (const auto& trial : scratch.trials[v].correlation) {
      if (std::isnan(trial[pixel])) {
        highest = -1;
        break;
      }
      highest = std::max(highest, trial[pixel]);
    }
    best[v] = highest;
    best_of_all = std::max(best_of_all, highest);
  }
  Curve curve;
  float sum = 0, squares = 0;
  for (std::size_t v = 0; v < views; ++v) {
    if (best[v] <= 0 || best[v] < best_of_all - kHidden) continue;
    const float weight = best[v] * best[v];
    for (std::size_t t = 0; t < kTrials; ++t) curve.mean[t] += weight * scratch.trials[v].correlation[t][pixel];
    sum += weight;
    squares += weight * weight;
  }
  if (!(sum > 0)) return std::nullopt;
  for (float& value : curve.mean) value /= sum;
  curve.views = sum * sum / squares;
  return curve;
}

struct Peak {
  float at = 0;  // [trials] from the middle one
  float correlation = 0;
  float variance = 0;  // [trials^2]
};

// The variance is that of least squares matching: residuals between pictures against the squared gradients, both
// expressed by the correlation and its curvature. The reference's own noise is common to all views.
std::optional<Peak> peak_of(const Curve& curve) {
  const auto& c = curve.mean;
  const int best = std::clamp(int(std::max_element(c.begin(), c.end()) - c.begin()), 1, kTrials - 2);
  const float left = c[std::size_t(best - 1)], middle = c[std::size_t(best)], right = c[std::size_t(best + 1)];
  const float curvature = 2 * middle - left - right;
  if (!(curvature > 1e-6f)) return std::nullopt;
  Peak peak;
  const float off = std::clamp(0.5f * (right - left) / curvature, -1.0f, 1.0f);
  peak.at = float(best - kTrials / 2) + off;
  peak.correlation = std::min(middle + 0.25f * (right - left) * off, 1.0f);
  peak.variance = (1 - peak.correlation + 1e-4f) / (curvature * kWindowPixels) * (1 + 1 / curve.views);
  return peak;
}

void refine_cell(const Level& level, const FloatImage& surface, int left, int top, float trial_step,
                 RefineScratch& scratch, Refined& result) {
  CellScene& scene = scratch.scene;
  scene.left = left;
  scene.top = top;
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i)
      scene.inverse_depth[std::size_t(j * kRegionWidth + i)] = surface.at(
          std::clamp(left - kRadius + i, 0, surface.width - 1), std::clamp(top - kRadius + j, 0, surface.height - 1));
  place_views(level, -level.step, level.step, scene);
  scratch.trials.resize(level.views.size());
  reference_region(*level.picture, left, top, scratch.reference.data());
  window_statistics(scratch.reference.data(), scratch.statistics);
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const View& view = level.views[std::size_t(scene.views[v])];
    for (int t = 0; t < kTrials; ++t) {
      const float w = float(t - kTrials / 2) * trial_step;
      const auto& b = view.transfer.b;
      sample(view.quads, scene.carried[v], w * b[0], w * b[1], w * b[2], scratch.sampled.data());
      correlate(scratch.reference.data(), scratch.statistics, scratch.sampled.data(),
                scratch.trials[v].correlation[std::size_t(t)].data());
    }
  }
  for (int y = top; y < std::min(top + kCell, surface.height); ++y)
    for (int x = left; x < std::min(left + kCell, surface.width); ++x) {
      const auto curve = curve_of(scratch, scene.views.size(), std::size_t((y - top) * kCell + x - left));
      const auto peak = curve ? peak_of(*curve) : std::nullopt;
      if (!peak) continue;
      result.inverse_depth.at(x, y) = surface.at(x, y) + peak->at * trial_step;
      result.sigma.at(x, y) = std::sqrt(peak->variance) * trial_step;
      result.correlation.at(x, y) = peak->correlation;
    }
}

}  // namespace

Refined refine(const Level& level, const FloatImage& surface, bool near, const Run& run) {
  const FloatImage empty(surface.width, surface.height, 1, kNaN);
  Refined result{empty, empty, empty};
  const int columns = (surface.width + kCell - 1) / kCell, rows = (surface.height + kCell - 1) / kCell;
  const float trial_step = level.step * (near ? 0.25f : 0.5f);
  parallel_for(run, std::size_t(rows), [&](std::size_t row) {
    const auto scratch = std::make_unique<RefineScratch>();
    for (int column = 0; column < columns && !run.stopped(); ++column)
      refine_cell(level, surface, column * kCell, int(row) * kCell, trial_step, *scratch, result);
  });
  return result;
}

FloatImage smoothed_within(const FloatImage& surface, float reach) {
  constexpr int kAround = 2;
  FloatImage result(surface.width, surface.height);
  for (int y = 0; y < surface.height; ++y)
    for (int x = 0; x < surface.width; ++x) {
      const float middle = surface.at(x, y);
      float sum = 0;
      int count = 0;
      for (int j = std::max(y - kAround, 0); j <= std::min(y + kAround, surface.height - 1); ++j)
        for (int i = std::max(x - kAround, 0); i <= std::min(x + kAround, surface.width - 1); ++i) {
          const float off = surface.at(i, j) - middle;
          if (!(std::abs(off) <= reach)) continue;
          sum += off;
          ++count;
        }
      result.at(x, y) = count ? middle + sum / float(count) : middle;
    }
  return result;
}

void remove_specks(FloatImage& surface, float reach, int min_pixels, const FloatImage* sigma) {
  const auto width = std::size_t(surface.width), height = std::size_t(surface.height);
  // every pixel points to one of its patch, the first of the patch to itself
  std::vector<std::uint32_t> patch(surface.data.size());
  const auto first_of = [&](std::uint32_t at) {
    while (patch[at] != at) at = patch[at] = patch[patch[at]];
    return at;
  };
  const auto goes_on = [&](std::size_t at, std::size_t before) {
    const float more = sigma ? 2 * (sigma->data[at] + sigma->data[before]) : 0;
    return std::abs(surface.data[before] - surface.data[at]) <= reach + more;
  };
  for (std::size_t y = 0, at = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x, ++at) {
      patch[at] = x > 0 && goes_on(at, at - 1) ? patch[at - 1] : std::uint32_t(at);
      if (y == 0 || !goes_on(at, at - width) || patch[at] == patch[at - width]) continue;
      const std::uint32_t a = first_of(patch[at]), b = first_of(patch[at - width]);
      patch[std::max(a, b)] = std::min(a, b);
      patch[at] = std::min(a, b);
    }
  }
  std::vector<int> pixels(patch.size(), 0);
  for (std::size_t at = 0; at < patch.size(); ++at) ++pixels[patch[at] = first_of(std::uint32_t(at))];
  for (std::size_t at = 0; at < patch.size(); ++at)
    if (pixels[patch[at]] < min_pixels) surface.data[at] = kNaN;
}

}  // namespace collinea::dense
