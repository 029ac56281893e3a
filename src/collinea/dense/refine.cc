// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "collinea/base/parallel.h"
#include "collinea/dense/internal/last_rows.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/measure_kernels.h"

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

void reference_region(const GreyImage& image, int left, int top, float* region) {
  for (int j = 0; j < kRegionHeight; ++j)
    for (int i = 0; i < kRegionWidth; ++i) {
      const int x = left - kRadius + i, y = top - kRadius + j;
      const bool there = x >= 0 && y >= 0 && x < image.width && y < image.height && image.at(x, y) != 0;
      region[j * kRegionWidth + i] = there ? float(image.at(x, y)) - 128 : kNaN;
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

// The variance is that of least squares matching: residuals between images against the squared gradients, both
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
  locate_views(level, -level.step, level.step, scene);
  scratch.trials.resize(level.views.size());
  reference_region(*level.image, left, top, scratch.reference.data());
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
  const auto empty = [&] { return FloatImage(surface.width, surface.height, 1, kNaN); };
  Refined result{empty(), empty(), empty()};
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
  const int width = surface.width, height = surface.height;
  LastRows rows(width, 2 * kAround + 1, kNaN), beyond(width, 1, kNaN);
  std::vector<float> mean(std::size_t(width + kRowSlack));
  FloatImage result(width, height);
  for (int y = 0; y < height + kAround; ++y) {
    if (y < height) std::copy_n(surface.row(y), width, rows.row(y));
    const int middle = y - kAround;
    if (middle < 0) continue;
    std::array<const float*, 2 * kAround + 1> around;
    for (int j = -kAround; j <= kAround; ++j) {
      const bool there = middle + j >= 0 && middle + j < height;
      around[std::size_t(j + kAround)] = there ? rows.row(middle + j) : beyond.row(0);
    }
    mean_within_row(around, reach, width, mean.data());
    std::copy_n(mean.begin(), width, result.row(middle));
  }
  return result;
}

}  // namespace collinea::dense
