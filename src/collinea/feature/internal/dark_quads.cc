// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/internal/dark_quads.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr int kTilePx = 4;
constexpr double kLargestExcess = 1.15;  // of the quadrilateral's area over that of the outline; of a circle 1.27
constexpr double kLeastSupport = 0.7;    // of a side: share with a rise of grey values

// --- what is dark

// Grey values below which a pixel is dark, of each tile; minus infinity where there is no contrast.
struct Thresholds {
  int width = 0, height = 0;  // tiles
  std::vector<float> of_tile;
};

Thresholds thresholds_of(const FloatImage& image, double least_contrast) {
  Thresholds out{(image.width + kTilePx - 1) / kTilePx, (image.height + kTilePx - 1) / kTilePx, {}};
  const auto w = std::size_t(out.width), h = std::size_t(out.height);
  std::vector<float> low(w * h, 1e30f), high(w * h, -1e30f);
  for (int y = 0; y < image.height; ++y) {
    const float* const row = image.row(y);
    float* const tile_low = &low[std::size_t(y / kTilePx) * w];
    float* const tile_high = &high[std::size_t(y / kTilePx) * w];
    for (int x = 0; x < image.width; ++x) {
      const auto t = std::size_t(x / kTilePx);
      tile_low[t] = std::min(tile_low[t], row[x]);
      tile_high[t] = std::max(tile_high[t], row[x]);
    }
  }
  out.of_tile.assign(w * h, -1e30f);
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      float least = 1e30f, most = -1e30f;
      for (int v = std::max(0, y - 1); v <= std::min(out.height - 1, y + 1); ++v)
        for (int u = std::max(0, x - 1); u <= std::min(out.width - 1, x + 1); ++u) {
          least = std::min(least, low[std::size_t(v) * w + std::size_t(u)]);
          most = std::max(most, high[std::size_t(v) * w + std::size_t(u)]);
        }
      if (most - least >= float(least_contrast)) out.of_tile[std::size_t(y) * w + std::size_t(x)] = (least + most) / 2;
    }
  return out;
}

// Dark pixels beside each other in a row.
struct DarkRun {
  int y, first, end;
};

// With the first run of each row, and one behind the last.
struct DarkRuns {
  std::vector<DarkRun> runs;
  std::vector<std::size_t> row_begins;
};

DarkRuns dark_runs(const FloatImage& image, const Thresholds& thresholds) {
  DarkRuns out;
  for (int y = 0; y < image.height; ++y) {
    out.row_begins.push_back(out.runs.size());
    const float* const row = image.row(y);
    const float* const limits = &thresholds.of_tile[std::size_t(y / kTilePx) * std::size_t(thresholds.width)];
    int first = -1;
    for (int x = 0; x < image.width; ++x) {
      const bool is_dark = row[x] < limits[x / kTilePx];
      if (is_dark && first < 0) first = x;
      if (!is_dark && first >= 0) {
        out.runs.push_back({y, first, x});
        first = -1;
      }
    }
    if (first >= 0) out.runs.push_back({y, first, image.width});
  }
  out.row_begins.push_back(out.runs.size());
  return out;
}

// --- what is connected

std::size_t root_of(std::vector<std::size_t>& parents, std::size_t i) {
  while (parents[i] != i) i = parents[i] = parents[parents[i]];
  return i;
}

// Of each run the first run of its component.
std::vector<std::size_t> components_of(const DarkRuns& dark) {
  std::vector<std::size_t> parents(dark.runs.size());
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  for (std::size_t y = 1; y + 1 < dark.row_begins.size(); ++y) {
    std::size_t above = dark.row_begins[y - 1];
    for (std::size_t i = dark.row_begins[y]; i < dark.row_begins[y + 1]; ++i) {
      while (above < dark.row_begins[y] && dark.runs[above].end <= dark.runs[i].first) ++above;
      for (std::size_t k = above; k < dark.row_begins[y] && dark.runs[k].first < dark.runs[i].end; ++k) {
        const std::size_t a = root_of(parents, i), b = root_of(parents, k);
        parents[std::max(a, b)] = std::min(a, b);
      }
    }
  }
  for (std::size_t i = 0; i < parents.size(); ++i) parents[i] = root_of(parents, i);
  return parents;
}

struct Extent {
  int left = 1 << 30, right = 0, top = 0, bottom = 0;
};

// Runs of the components that are large enough, one after the other, each from above.
std::vector<std::vector<DarkRun>> large_components(const DarkRuns& dark, double least_side_px) {
  const std::vector<std::size_t> component = components_of(dark);
  std::vector<Extent> extents(dark.runs.size());
  for (std::size_t i = 0; i < dark.runs.size(); ++i) {
    Extent& e = extents[component[i]];
    const DarkRun& run = dark.runs[i];
    if (component[i] == i) e.top = run.y;
    e.left = std::min(e.left, run.first);
    e.right = std::max(e.right, run.end);
    e.bottom = run.y + 1;
  }
  const auto is_large = [&](const Extent& e) {
    return std::min(e.right - e.left, e.bottom - e.top) >= 0.75 * least_side_px &&
           std::max(e.right - e.left, e.bottom - e.top) >= least_side_px;
  };
  std::vector<std::size_t> number(dark.runs.size());
  std::vector<std::vector<DarkRun>> out;
  for (std::size_t i = 0; i < dark.runs.size(); ++i) {
    if (!is_large(extents[component[i]])) continue;
    if (component[i] == i) {
      number[i] = out.size();
      out.emplace_back();
    }
    out[number[component[i]]].push_back(dark.runs[i]);
  }
  return out;
}

// --- outlines

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

double area_of(const std::vector<Vector2d>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) twice += cross(polygon[i], polygon[(i + 1) % polygon.size()]);
  return twice / 2;
}

// The convex hull of the pixels of a component, clockwise in the image.
std::vector<Vector2d> hull_of(const std::vector<DarkRun>& runs) {
  struct Row {
    int y, left, right;
  };
  std::vector<Row> rows;
  for (const DarkRun& run : runs) {
    if (rows.empty() || rows.back().y != run.y) rows.push_back({run.y, run.first, run.end});
    rows.back().left = std::min(rows.back().left, run.first);
    rows.back().right = std::max(rows.back().right, run.end);
  }
  std::vector<Vector2d> hull;
  const auto add = [&](const Vector2d& p) {  // on the way round, clockwise
    while (hull.size() > 1 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) hull.pop_back();
    hull.push_back(p);
  };
  for (const Row& row : rows) {
    add(Vector2d(row.right, row.y));
    add(Vector2d(row.right, row.y + 1));
  }
  const std::vector<Vector2d> right = std::move(hull);
  hull.clear();
  for (auto row = rows.rbegin(); row != rows.rend(); ++row) {
    add(Vector2d(row->left, row->y + 1));
    add(Vector2d(row->left, row->y));
  }
  std::vector<Vector2d> out = right;
  out.insert(out.end(), hull.begin(), hull.end());
  return out;
}

// Where the line through a and b meets that through c and d, if it lies ahead of b and behind c.
std::optional<Vector2d> meeting_ahead(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const Vector2d along = b - a, back = c - d;
  const double determinant = cross(along, back);
  if (!(std::abs(determinant) > 1e-9)) return std::nullopt;
  const double t = cross(c - b, back) / determinant, s = cross(c - b, along) / determinant;
  if (t < 0 || s < 0) return std::nullopt;
  return b + t * along;
}

}  // namespace

std::vector<Vector2d> quad_about(std::vector<Vector2d> p) {
  while (p.size() > 4) {
    const std::size_t n = p.size();
    double least = 1e300;
    std::size_t best = n;
    Vector2d corner;
    for (std::size_t i = 0; i < n; ++i) {  // the side from i to i + 1 is left out
      const Vector2d &b = p[i], &c = p[(i + 1) % n];
      const auto meeting = meeting_ahead(p[(i + n - 1) % n], b, c, p[(i + 2) % n]);
      if (!meeting) continue;
      const double added = std::abs(cross(*meeting - b, c - b)) / 2;
      if (added < least) {
        least = added;
        best = i;
        corner = *meeting;
      }
    }
    if (best == n) return {};
    p[best] = corner;
    p.erase(p.begin() + std::ptrdiff_t((best + 1) % n));
  }
  return p.size() == 4 ? p : std::vector<Vector2d>{};
}

namespace {

bool is_shapely(const Quad& q, double least_side_px) {
  for (std::size_t i = 0; i < 4; ++i) {
    const Vector2d along = q[(i + 1) % 4] - q[i], next = q[(i + 2) % 4] - q[(i + 1) % 4];
    const double length = along.norm(), other = next.norm();
    if (!(length >= least_side_px) || !(cross(along, next) > 0.3 * length * other)) return false;  // 17 degrees
    if (length > 6 * other || other > 6 * length) return false;
  }
  return true;
}

std::optional<Quad> quad_of(const std::vector<DarkRun>& runs, double least_side_px) {
  const std::vector<Vector2d> hull = hull_of(runs);
  const std::vector<Vector2d> about = quad_about(hull);
  if (about.size() != 4) return std::nullopt;
  const double area = area_of(hull);
  if (!(area_of(about) <= kLargestExcess * area)) return std::nullopt;
  const Quad quad{about[0], about[1], about[2], about[3]};
  return is_shapely(quad, 0.7 * least_side_px) ? std::optional(quad) : std::nullopt;
}

// --- sides

struct Line {
  Vector2d at, along;
};

// Through positions by least squares of distances, once more without the farthest.
std::optional<Line> line_through(std::vector<Vector2d> points, const Vector2d& along) {
  std::optional<Line> line;
  const Vector2d direction = along.normalized(), across(-direction.y(), direction.x());
  for (int pass = 0; pass < 2; ++pass) {
    double n = 0, s = 0, ss = 0, t = 0, st = 0;
    for (const Vector2d& p : points) {
      const double u = p.dot(direction), v = p.dot(across);
      n += 1, s += u, ss += u * u, t += v, st += u * v;
    }
    const double determinant = n * ss - s * s;
    if (n < 3 || !(determinant > 1e-9)) return std::nullopt;
    const double slope = (n * st - s * t) / determinant, base = (t - slope * s) / n;
    line = Line{base * across, direction + slope * across};
    const auto off = [&](const Vector2d& p) { return std::abs(p.dot(across) - base - slope * p.dot(direction)); };
    double mean = 0;
    for (const Vector2d& p : points) mean += off(p) / n;
    std::erase_if(points, [&](const Vector2d& p) { return off(p) > std::max(0.3, 2.5 * mean); });
  }
  return line;
}

// Where the grey value rises most across a side, from dark inside to light outside.
std::optional<Line> side_line(const FloatImage& image, const Vector2d& from, const Vector2d& to,
                              double least_contrast) {
  const Vector2d along = to - from;
  const double length = along.norm();
  const Vector2d out(along.y() / length, -along.x() / length);  // clockwise: the inside lies on the right
  const int count = std::clamp(int(length), 8, 40);
  const double reach = std::clamp(length / 8, 1.5, 3.0);
  constexpr double kStep = 0.5;
  const int steps = int(std::ceil(reach / kStep));
  std::vector<Vector2d> points;
  for (int i = 0; i < count; ++i) {
    const Vector2d p = from + (0.1 + 0.8 * (i + 0.5) / count) * along;
    std::array<double, 16> rise{};
    int best = -1;
    for (int k = -steps; k <= steps; ++k) {
      const Vector2d inner = p + (k * kStep - 0.75) * out, outer = p + (k * kStep + 0.75) * out;
      rise[std::size_t(k + steps)] = bilinear(image, outer.x(), outer.y()) - bilinear(image, inner.x(), inner.y());
      if (best < 0 || rise[std::size_t(k + steps)] > rise[std::size_t(best)]) best = k + steps;
    }
    if (best <= 0 || best >= 2 * steps || rise[std::size_t(best)] < least_contrast / 4) continue;
    const double before = rise[std::size_t(best) - 1], here = rise[std::size_t(best)],
                 behind = rise[std::size_t(best) + 1];
    const double bend = before + behind - 2 * here;
    const double peak = bend < 0 ? 0.5 * (before - behind) / bend : 0;
    points.push_back(p + (best - steps + peak) * kStep * out);
  }
  if (double(points.size()) < kLeastSupport * count) return std::nullopt;
  return line_through(std::move(points), along);
}

std::optional<Quad> fitted(const FloatImage& image, const Quad& quad, double least_contrast) {
  std::array<Line, 4> sides;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto side = side_line(image, quad[i], quad[(i + 1) % 4], least_contrast);
    if (!side) return std::nullopt;
    sides[i] = *side;
  }
  Quad out;
  for (std::size_t i = 0; i < 4; ++i) {
    const Line &a = sides[(i + 3) % 4], &b = sides[i];
    const double determinant = cross(a.along, b.along);
    if (!(std::abs(determinant) > 0.1)) return std::nullopt;
    out[i] = a.at + cross(b.at - a.at, b.along) / determinant * a.along;
    if (!((out[i] - quad[i]).norm() < 6)) return std::nullopt;
  }
  return out;
}

}  // namespace

std::vector<Quad> dark_quads(const FloatImage& image, double least_contrast, double least_side_px) {
  std::vector<Quad> out;
  if (image.empty()) return out;
  const DarkRuns dark = dark_runs(image, thresholds_of(image, least_contrast));
  for (const std::vector<DarkRun>& runs : large_components(dark, least_side_px)) {
    const auto quad = quad_of(runs, least_side_px);
    const auto sharp = quad ? fitted(image, *quad, least_contrast) : std::nullopt;
    if (sharp && is_shapely(*sharp, least_side_px)) out.push_back(*sharp);
  }
  return out;
}

}  // namespace collinea
