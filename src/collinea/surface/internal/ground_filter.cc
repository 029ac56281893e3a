// SPDX-License-Identifier: Apache-2.0
#include "collinea/surface/internal/ground_filter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/surface/internal/pull_push.h"
#include "collinea/surface/surface_filter.h"

namespace collinea {
namespace {

using Mask = Raster<std::uint8_t>;

constexpr double kSlope = 0.15;  // rise per run by which ground may bulge within a square
constexpr double kPit = 2.5;     // depth below all neighbours, in cells: a wrong height
constexpr double kStep = 0.7;    // rise per run over the rim of an object
constexpr double kGrowth = 1.2;  // of the squares
constexpr int kLanes = 64;       // columns at a time

struct Smallest {
  static constexpr float kNone = std::numeric_limits<float>::infinity();
  float operator()(float a, float b) const { return std::min(a, b); }
};
struct Largest {
  static constexpr float kNone = -std::numeric_limits<float>::infinity();
  float operator()(float a, float b) const { return std::max(a, b); }
};

// Along a line of `count` positions, `step` values apart, with `lanes` values side by side at each: the best of the 2 r
// + 1 positions around each (van Herk 1992: every window is the end of one block and the beginning of the next, and
// both are known from running along the blocks once each way). `out` may be `in`.
template <class Best>
void best_along(const float* in, std::size_t step, int count, int lanes, int r, float* out,
                std::vector<float>& buffer) {
  const Best best;
  const int size = 2 * r + 1, padded = count + 2 * r;
  const auto n = std::size_t(lanes);
  buffer.assign(2 * std::size_t(padded) * n, Best::kNone);
  float* const onward = buffer.data();
  float* const back = onward + std::size_t(padded) * n;
  for (int i = 0; i < count; ++i) {
    std::copy_n(in + std::size_t(i) * step, n, onward + std::size_t(i + r) * n);
    std::copy_n(in + std::size_t(i) * step, n, back + std::size_t(i + r) * n);
  }
  for (int i = 1; i < padded; ++i)
    if (i % size != 0)
      for (std::size_t k = std::size_t(i) * n; k < std::size_t(i + 1) * n; ++k)
        onward[k] = best(onward[k], onward[k - n]);
  for (int i = padded - 2; i >= 0; --i)
    if ((i + 1) % size != 0)
      for (std::size_t k = std::size_t(i) * n; k < std::size_t(i + 1) * n; ++k) back[k] = best(back[k], back[k + n]);
  for (int i = 0; i < count; ++i)
    for (std::size_t k = 0; k < n; ++k)
      out[std::size_t(i) * step + k] = best(back[std::size_t(i) * n + k], onward[std::size_t(i + 2 * r) * n + k]);
}

template <class Best>
FloatImage best_around(FloatImage heights, int r, const Run& run) {
  parallel_for(run, std::size_t(heights.height), [&](std::size_t y) {
    std::vector<float> buffer;
    best_along<Best>(heights.row(int(y)), 1, heights.width, 1, r, heights.row(int(y)), buffer);
  });
  const int chunks = (heights.width + kLanes - 1) / kLanes;
  parallel_for(run, std::size_t(chunks), [&](std::size_t chunk) {
    std::vector<float> buffer;
    const int column = int(chunk) * kLanes, lanes = std::min(kLanes, heights.width - column);
    float* const first = heights.row(0) + column;
    best_along<Best>(first, std::size_t(heights.width), heights.height, lanes, r, first, buffer);
  });
  return heights;
}

// Heights far below all around them are raised to the lowest of these, and marked.
void raise_pits(FloatImage& surface, double cell_m, Mask& taken, const Run& run) {
  const FloatImage closed = smallest_around(largest_around(surface, 1, run), 1, run);
  for (std::size_t i = 0; i < surface.data.size(); ++i) {
    if (closed.data[i] - surface.data[i] <= float(kPit * cell_m)) continue;
    surface.data[i] = closed.data[i];
    taken.data[i] = 1;
  }
}

void take_objects(FloatImage surface, double cell_m, double largest_object_m, Mask& taken, const Run& run) {
  const int largest = std::max(1, int(std::ceil(largest_object_m / cell_m / 2)));
  for (int r = 1; !run.stopped(); r = std::min(largest, std::max(r + 1, int(std::lround(kGrowth * r))))) {
    FloatImage opened = largest_around(smallest_around(surface, r, run), r, run);
    for (std::size_t i = 0; i < surface.data.size(); ++i)
      if (surface.data[i] - opened.data[i] > float(kSlope * r * cell_m)) taken.data[i] = 1;
    surface = std::move(opened);
    if (r == largest) return;
  }
}

// Smooth patches of what was taken away: neighbours (of 8) without a step between them. A patch that lies beside
// ground, mostly without a step, is ground itself.
class GivingBack {
 public:
  GivingBack(const FloatImage& low_m, double cell_m, Mask& taken)
      : low_m_(low_m), cell_m_(cell_m), taken_(taken), visited_(taken.width, taken.height) {}

  void all() {
    Mask after = taken_;
    for (int y = 0; y < taken_.height; ++y)
      for (int x = 0; x < taken_.width; ++x)
        if (taken_.at(x, y) && !visited_.at(x, y) && is_ground(x, y))
          for (const auto& [u, v] : patch_) after.at(u, v) = 0;
    taken_ = std::move(after);
  }

 private:
  // Finds the patch around a position.
  bool is_ground(int x, int y) {
    patch_.assign(1, {x, y});
    visited_.at(x, y) = 1;
    std::size_t rim = 0, steps = 0;
    for (std::size_t next = 0; next < patch_.size(); ++next) {
      const auto [u, v] = patch_[next];
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int s = u + dx, t = v + dy;
          if (s < 0 || t < 0 || s >= taken_.width || t >= taken_.height) continue;
          const double rise_m = double(low_m_.at(u, v)) - double(low_m_.at(s, t));
          if (std::isnan(rise_m)) continue;
          const double step_m = kStep * cell_m_ * std::hypot(dx, dy);
          if (!taken_.at(s, t)) {
            ++rim;
            steps += rise_m > step_m;
          } else if (!visited_.at(s, t) && std::abs(rise_m) <= step_m) {
            visited_.at(s, t) = 1;
            patch_.push_back({s, t});
          }
        }
    }
    return 2 * steps < rim;
  }

  const FloatImage& low_m_;
  double cell_m_;
  Mask& taken_;
  Mask visited_;
  std::vector<std::pair<int, int>> patch_;
};

}  // namespace

FloatImage smallest_around(FloatImage heights, int radius, const Run& run) {
  return best_around<Smallest>(std::move(heights), radius, run);
}

FloatImage largest_around(FloatImage heights, int radius, const Run& run) {
  return best_around<Largest>(std::move(heights), radius, run);
}

Mask ground_cells(const FloatImage& low_m, double cell_m, double largest_object_m, const Run& run) {
  FloatImage surface = filled(low_m, cell_m);
  Mask pits(low_m.width, low_m.height), taken = pits;
  raise_pits(surface, cell_m, pits, run);
  take_objects(std::move(surface), cell_m, largest_object_m, taken, run);
  GivingBack(low_m, cell_m, taken).all();
  for (std::size_t i = 0; i < taken.data.size(); ++i)
    taken.data[i] = !taken.data[i] && !pits.data[i] && !std::isnan(low_m.data[i]);
  return taken;
}

}  // namespace collinea
