// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/extrema.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

namespace collinea {
namespace {

constexpr int kBorder_px = 5;
constexpr int kMoves = 5;
static_assert(ExtremumSearch::kReach == kMoves + 1);
constexpr double kWhite = 255;

struct Position {
  int level, y, x;  // in this order: sorted as they are found
  friend auto operator<=>(const Position&, const Position&) = default;
};

// Differences of Gaussians and their derivatives, straight from the blurred planes.
class Differences {
 public:
  explicit Differences(const Octave& octave) : octave_(octave) {}

  [[nodiscard]] double at(int level, int y, int x) const {
    const auto l = static_cast<std::size_t>(level);
    return double{octave_[l + 1].at(x, y)} - octave_[l].at(x, y);
  }
  [[nodiscard]] double at(const Position& p) const { return at(p.level, p.y, p.x); }

  struct Quadratic {
    double value, gx, gy, gl, xx, yy, ll, xy, xl, yl;
  };
  [[nodiscard]] Quadratic quadratic(const Position& p) const {
    const int l = p.level, y = p.y, x = p.x;
    const double value = at(p);
    const double left = at(l, y, x - 1), right = at(l, y, x + 1), up = at(l, y - 1, x), down = at(l, y + 1, x);
    const double finer = at(l - 1, y, x), coarser = at(l + 1, y, x);
    return {.value = value,
            .gx = (right - left) / 2,
            .gy = (down - up) / 2,
            .gl = (coarser - finer) / 2,
            .xx = right + left - 2 * value,
            .yy = down + up - 2 * value,
            .ll = coarser + finer - 2 * value,
            .xy = (at(l, y + 1, x + 1) - at(l, y + 1, x - 1) - at(l, y - 1, x + 1) + at(l, y - 1, x - 1)) / 4,
            .xl = (at(l + 1, y, x + 1) - at(l + 1, y, x - 1) - at(l - 1, y, x + 1) + at(l - 1, y, x - 1)) / 4,
            .yl = (at(l + 1, y + 1, x) - at(l + 1, y - 1, x) - at(l - 1, y + 1, x) + at(l - 1, y - 1, x)) / 4};
  }

 private:
  const Octave& octave_;
};

struct Offset {
  double x, y, level;
};

// Where the quadratic has its extremum, by Cramer's rule.
std::optional<Offset> summit(const Differences::Quadratic& q) {
  const double a = q.yy * q.ll - q.yl * q.yl, b = q.xl * q.yl - q.xy * q.ll, c = q.xy * q.yl - q.xl * q.yy;
  const double determinant = q.xx * a + q.xy * b + q.xl * c;
  if (std::abs(determinant) < 1e-12) return std::nullopt;
  const double d = q.xx * q.ll - q.xl * q.xl, e = q.xy * q.xl - q.xx * q.yl, f = q.xx * q.yy - q.xy * q.xy;
  return Offset{-(a * q.gx + b * q.gy + c * q.gl) / determinant, -(b * q.gx + d * q.gy + e * q.gl) / determinant,
                -(c * q.gx + e * q.gy + f * q.gl) / determinant};
}

bool is_edge(const Differences::Quadratic& q, double ratio) {
  const double trace = q.xx + q.yy, determinant = q.xx * q.yy - q.xy * q.xy;
  return determinant <= 0 || trace * trace * ratio > (ratio + 1) * (ratio + 1) * determinant;
}

// Two curvatures that differ let the position slip along the ridge: 1 for equal ones, 2 sqrt(r) / (r + 1) for a ratio
// r.
double roundness(const Differences::Quadratic& q) {
  const double determinant = q.xx * q.yy - q.xy * q.xy;
  return 2 * std::sqrt(std::max(0.0, determinant)) / std::abs(q.xx + q.yy);
}

struct Summit {
  Position position;
  Extremum extremum;
};

// Follows the quadratic from pixel to pixel until its summit belongs to the pixel it was taken at.
std::optional<Summit> located(const Octave& octave, Position position, double least_contrast, double edge_ratio) {
  const Differences differences(octave);
  const int width = octave[0].width(), height = octave[0].height();
  // A little more than half a pixel: a summit between two pixels must not be passed on for ever.
  const auto step = [](double offset) { return offset > 0.6 ? 1 : offset < -0.6 ? -1 : 0; };
  for (int move = 0; move <= kMoves; ++move) {
    const Differences::Quadratic q = differences.quadratic(position);
    const std::optional<Offset> offset = summit(q);
    if (!offset) return std::nullopt;
    const Position next{position.level + step(offset->level), position.y + step(offset->y),
                        position.x + step(offset->x)};
    if (next == position) {
      const double value = q.value + (q.gx * offset->x + q.gy * offset->y + q.gl * offset->level) / 2;
      const double contrast = std::abs(value) / kWhite;
      if (contrast < least_contrast || is_edge(q, edge_ratio)) return std::nullopt;
      return Summit{position,
                    {static_cast<float>(position.x + offset->x), static_cast<float>(position.y + offset->y),
                     static_cast<float>(position.level + offset->level), static_cast<float>(contrast * roundness(q))}};
    }
    position = next;
    if (position.level < 1 || position.level > kSteps || position.x < kBorder_px || position.y < kBorder_px ||
        position.x >= width - kBorder_px || position.y >= height - kBorder_px)
      return std::nullopt;
  }
  return std::nullopt;
}

// Pixels of a band larger or smaller than all their neighbours in x, y and level.
std::vector<Position> candidates(const Octave& octave, int begin, int end, double least_contrast) {
  constexpr int kDifferences = kLevels - 1;
  const int width = octave[0].width();
  // The sampled extremum is smaller than the true one between the pixels.
  const float threshold = static_cast<float>(0.8 * least_contrast * kWhite);
  Plane ring(width, 3 * kDifferences);
  const auto ring_row = [&](int level, int y) { return ring.row(3 * level + y % 3); };
  const auto fill = [&](int y) {
    for (int level = 0; level < kDifferences; ++level) {
      const auto l = static_cast<std::size_t>(level);
      subtract_rows(octave[l + 1].row(y), octave[l].row(y), width, ring_row(level, y));
    }
  };
  std::vector<Position> positions;
  std::vector<std::int32_t> found(static_cast<std::size_t>(width));
  begin = std::max(begin, kBorder_px);
  end = std::min(end, octave[0].height() - kBorder_px);
  if (begin >= end) return {};
  for (int y = begin - 1; y <= begin; ++y) fill(y);
  for (int y = begin; y < end; ++y) {
    fill(y + 1);
    for (int level = 1; level <= kSteps; ++level) {
      std::array<const float*, 9> rows;
      for (int k = 0; k < 9; ++k) rows[static_cast<std::size_t>(k)] = ring_row(level - 1 + k / 3, y - 1 + k % 3);
      const int count = extrema_of_row(rows.data(), kBorder_px, width - kBorder_px, threshold, found.data());
      for (int i = 0; i < count; ++i) positions.push_back({level, y, found[static_cast<std::size_t>(i)]});
    }
  }
  return positions;
}

}  // namespace

void ExtremumSearch::look(const Octave& octave, int begin, int end) {
  if (octave[0].width() <= 2 * kBorder_px || octave[0].height() <= 2 * kBorder_px) return;
  for (const Position& position : candidates(octave, begin, end, least_contrast_))
    if (const auto one = located(octave, position, least_contrast_, edge_ratio_))
      located_.push_back({one->position.level, one->position.y, one->position.x, one->extremum});
}

std::vector<Extremum> ExtremumSearch::found() && {
  const auto position = [](const Located& one) { return std::tuple(one.level, one.y, one.x); };
  std::ranges::sort(located_, {}, position);
  // Two candidates may have moved to the same position.
  const auto same = std::ranges::unique(located_, {}, position);
  located_.erase(same.begin(), same.end());
  std::vector<Extremum> extrema;
  extrema.reserve(located_.size());
  for (const Located& one : located_) extrema.push_back(one.extremum);
  return extrema;
}

}  // namespace collinea
