// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/delaunay.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace collinea {
namespace {

constexpr int kLatticeBits = 26;
constexpr int kInfinity = -1;    // as a corner
constexpr double kRounding = 3;  // lattice steps by which points of a line may lie beside it
__extension__ using Int128 = __int128;

struct Lattice {
  std::int64_t x = 0, y = 0;

  bool operator==(const Lattice&) const = default;
};

// Twice the area of a triangle: positive when it is counter-clockwise.
std::int64_t turn(const Lattice& a, const Lattice& b, const Lattice& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

// Whether p lies within the circle through a, b, c, which are counter-clockwise.
bool in_circle(const Lattice& a, const Lattice& b, const Lattice& c, const Lattice& p) {
  const std::int64_t ax = a.x - p.x, ay = a.y - p.y, bx = b.x - p.x, by = b.y - p.y, cx = c.x - p.x, cy = c.y - p.y;
  const Int128 a_part = Int128(ax * ax + ay * ay) * (bx * cy - by * cx);
  const Int128 b_part = Int128(bx * bx + by * by) * (cx * ay - cy * ax);
  const Int128 c_part = Int128(cx * cx + cy * cy) * (ax * by - ay * bx);
  return a_part + b_part + c_part > 0;
}

// The position along a curve that visits quarters of quarters of the square (Morton).
std::uint64_t along_curve(const Lattice& at) {
  std::uint64_t code = 0;
  for (int bit = kLatticeBits; bit >= 0; --bit)
    code = code << 2 | std::uint64_t(at.x >> bit & 1) << 1 | std::uint64_t(at.y >> bit & 1);
  return code;
}

using Triangle = Delaunay::Triangle;

class Builder {
 public:
  explicit Builder(std::vector<Lattice> points) : points_(std::move(points)) {}

  // Puts in all points; false when they lie on a line.
  bool build();
  // Those without a corner at infinity.
  [[nodiscard]] std::vector<Triangle> finite() const;

 private:
  bool start(std::vector<int>& order);
  void insert(int point);
  [[nodiscard]] int walk(int point) const;
  [[nodiscard]] bool conflicts(int triangle, int point) const;
  void collect(int triangle, int point);
  void fill(int point);

  // An edge of the hole that a new point opens, seen counter-clockwise from within.
  struct Edge {
    int from, to, outside;
  };

  std::vector<Lattice> points_;
  std::vector<Triangle> triangles_;
  std::vector<int> free_, hole_;
  std::vector<std::uint8_t> state_;  // of a triangle: 1 in the hole
  std::vector<Edge> edges_;
  std::vector<int> fan_of_;  // by the corner a new triangle's edge starts from; the last place is infinity
  int last_ = 0;
};

bool Builder::build() {
  std::vector<int> order(points_.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<std::uint64_t> codes;
  for (const Lattice& point : points_) codes.push_back(along_curve(point));
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return std::pair(codes[std::size_t(a)], a) < std::pair(codes[std::size_t(b)], b); });
  // Those on one place lie side by side.
  order.erase(std::unique(order.begin(), order.end(),
                          [&](int a, int b) { return points_[std::size_t(a)] == points_[std::size_t(b)]; }),
              order.end());
  if (order.size() < 3 || !start(order)) return false;
  fan_of_.assign(points_.size() + 1, -1);
  for (std::size_t i = 3; i < order.size(); ++i) insert(order[i]);
  return true;
}

// The first triangle and the three outside it; its corners become the first three of `order`.
bool Builder::start(std::vector<int>& order) {
  const auto at = [&](std::size_t i) -> const Lattice& { return points_[std::size_t(order[i])]; };
  std::size_t third = 2;
  while (third < order.size() && turn(at(0), at(1), at(third)) == 0) ++third;
  if (third == order.size()) return false;
  std::rotate(order.begin() + 2, order.begin() + std::ptrdiff_t(third), order.begin() + std::ptrdiff_t(third) + 1);
  int a = order[0], b = order[1];
  const int c = order[2];
  if (turn(at(0), at(1), at(2)) < 0) std::swap(a, b);
  triangles_ = {{{a, b, c}, {2, 3, 1}},
                {{b, a, kInfinity}, {3, 2, 0}},
                {{c, b, kInfinity}, {1, 3, 0}},
                {{a, c, kInfinity}, {2, 1, 0}}};
  state_.assign(4, 0);
  return true;
}

// Whether a triangle has to go for a point. One with a corner at infinity does when the point lies beyond its edge, or
// on the edge itself.
bool Builder::conflicts(int triangle, int point) const {
  const auto& corners = triangles_[std::size_t(triangle)].corners;
  const Lattice& p = points_[std::size_t(point)];
  const auto at = [&](int i) -> const Lattice& { return points_[std::size_t(corners[std::size_t(i % 3)])]; };
  for (int i = 0; i < 3; ++i) {
    if (corners[std::size_t(i)] != kInfinity) continue;
    const Lattice &a = at(i + 1), &b = at(i + 2);
    const std::int64_t side = turn(a, b, p);
    if (side != 0) return side > 0;
    return (p.x - a.x) * (p.x - b.x) + (p.y - a.y) * (p.y - b.y) < 0;
  }
  return in_circle(at(0), at(1), at(2), p);
}

// The triangle a point lies in, or one outside beyond whose edge it lies.
int Builder::walk(int point) const {
  const Lattice& p = points_[std::size_t(point)];
  int triangle = last_;
  for (bool moved = true; moved;) {
    moved = false;
    const auto& [corners, neighbours] = triangles_[std::size_t(triangle)];
    for (std::size_t i = 0; i < 3 && !moved; ++i) {
      const int a = corners[(i + 1) % 3], b = corners[(i + 2) % 3];
      if (corners[0] == kInfinity || corners[1] == kInfinity || corners[2] == kInfinity) {
        if (corners[i] != kInfinity || conflicts(triangle, point)) continue;
      } else if (turn(points_[std::size_t(a)], points_[std::size_t(b)], p) >= 0) {
        continue;
      }
      triangle = neighbours[i];
      moved = true;
    }
  }
  return triangle;
}

void Builder::collect(int first, int point) {
  hole_ = {first};
  edges_.clear();
  state_[std::size_t(first)] = 1;
  for (std::size_t next = 0; next < hole_.size(); ++next) {
    const auto [corners, neighbours] = triangles_[std::size_t(hole_[next])];
    for (std::size_t i = 0; i < 3; ++i) {
      const int beyond = neighbours[i];
      if (state_[std::size_t(beyond)] == 1) continue;
      if (conflicts(beyond, point)) {
        state_[std::size_t(beyond)] = 1;
        hole_.push_back(beyond);
      } else {
        edges_.push_back({corners[(i + 1) % 3], corners[(i + 2) % 3], beyond});
      }
    }
  }
}

// New triangles from the point to every edge of the hole, in the places of those that go.
void Builder::fill(int point) {
  const auto index_of = [&](int corner) { return corner == kInfinity ? points_.size() : std::size_t(corner); };
  for (const int in_hole : hole_) state_[std::size_t(in_hole)] = 0;
  while (hole_.size() < edges_.size()) {
    hole_.push_back(int(triangles_.size()));
    triangles_.push_back({});
    state_.push_back(0);
  }
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const Edge& edge = edges_[i];
    triangles_[std::size_t(hole_[i])] = {{point, edge.from, edge.to}, {edge.outside, -1, -1}};
    fan_of_[index_of(edge.from)] = hole_[i];
    Triangle& outside = triangles_[std::size_t(edge.outside)];
    for (std::size_t k = 0; k < 3; ++k)
      if (outside.corners[(k + 1) % 3] == edge.to && outside.corners[(k + 2) % 3] == edge.from)
        outside.neighbours[k] = hole_[i];
  }
  for (std::size_t i = 0; i < edges_.size(); ++i) {
    const int next = fan_of_[index_of(edges_[i].to)];
    triangles_[std::size_t(hole_[i])].neighbours[1] = next;
    triangles_[std::size_t(next)].neighbours[2] = hole_[i];
  }
  last_ = hole_[0];
}

void Builder::insert(int point) {
  collect(walk(point), point);
  fill(point);
}

std::vector<Triangle> Builder::finite() const {
  std::vector<int> number(triangles_.size(), -1);
  std::vector<Triangle> kept;
  for (std::size_t i = 0; i < triangles_.size(); ++i) {
    const auto& corners = triangles_[i].corners;
    if (std::find(corners.begin(), corners.end(), kInfinity) != corners.end()) continue;
    number[i] = int(kept.size());
    kept.push_back(triangles_[i]);
  }
  for (Triangle& triangle : kept)
    for (int& neighbour : triangle.neighbours) neighbour = number[std::size_t(neighbour)];
  return kept;
}

}  // namespace

namespace {

// Whether no point is farther from the line through the first and the one farthest from it than rounding to the lattice
// moves it.
bool on_a_line(const std::vector<Lattice>& points) {
  const Lattice& from = points.front();
  const auto distance2 = [&](const Lattice& p) {
    return (p.x - from.x) * (p.x - from.x) + (p.y - from.y) * (p.y - from.y);
  };
  const Lattice to = *std::max_element(points.begin(), points.end(),
                                       [&](const Lattice& a, const Lattice& b) { return distance2(a) < distance2(b); });
  const double length = std::sqrt(double(distance2(to)));
  return std::all_of(points.begin(), points.end(),
                     [&](const Lattice& p) { return std::abs(double(turn(from, to, p))) <= kRounding * length; });
}

}  // namespace

std::optional<Delaunay> Delaunay::of(std::span<const Eigen::Vector2d> points) {
  if (points.size() < 3) return std::nullopt;
  Eigen::Vector2d low = points[0], high = points[0];
  for (const Eigen::Vector2d& point : points) {
    if (!point.allFinite()) return std::nullopt;
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  const double extent = (high - low).maxCoeff();
  if (!(extent > 0)) return std::nullopt;
  const double step = extent / double(std::int64_t{1} << kLatticeBits);
  std::vector<Lattice> lattice;
  lattice.reserve(points.size());
  for (const Eigen::Vector2d& point : points)
    lattice.push_back({std::llround((point.x() - low.x()) / step), std::llround((point.y() - low.y()) / step)});
  if (on_a_line(lattice)) return std::nullopt;
  Delaunay made;
  for (const Lattice& at : lattice) made.points_.emplace_back(low + step * Eigen::Vector2d(double(at.x), double(at.y)));
  Builder builder(std::move(lattice));
  if (!builder.build()) return std::nullopt;
  made.triangles_ = builder.finite();
  made.low_ = low;
  made.squares_ = std::max(int(std::sqrt(double(points.size())) / 2), 1);
  made.square_ = ((high - low) / made.squares_).cwiseMax(step);
  int triangle = 0;
  for (int y = 0; y < made.squares_; ++y)
    for (int x = 0; x < made.squares_; ++x) {
      const auto found = made.walk(low + made.square_.cwiseProduct(Eigen::Vector2d(x + 0.5, y + 0.5)), triangle);
      made.start_.push_back(triangle = found ? found->triangle : triangle);
    }
  return made;
}

std::size_t Delaunay::square_of(const Eigen::Vector2d& position) const {
  const Eigen::Vector2d at = (position - low_).cwiseQuotient(square_);
  const auto limited = [&](double value) { return std::size_t(std::clamp(value, 0.0, squares_ - 1.0)); };
  return limited(at.y()) * std::size_t(squares_) + limited(at.x());
}

std::optional<Delaunay::Location> Delaunay::find(const Eigen::Vector2d& position) const {
  return walk(position, start_[square_of(position)]);
}

std::optional<Delaunay::Location> Delaunay::walk(const Eigen::Vector2d& position, int triangle) const {
  // A walk of straight line steps ends after fewer triangles than there are, but for rounding on an edge.
  for (std::size_t steps = 0; steps < triangles_.size() + 3; ++steps) {
    const Triangle& here = triangles_[std::size_t(triangle)];
    Location location{triangle, {}};
    double sum = 0, least = 0;
    std::size_t across = 3;
    for (std::size_t i = 0; i < 3; ++i) {
      const Eigen::Vector2d a = points_[std::size_t(here.corners[(i + 1) % 3])] - position;
      const Eigen::Vector2d b = points_[std::size_t(here.corners[(i + 2) % 3])] - position;
      location.weights[i] = a.x() * b.y() - a.y() * b.x();
      sum += location.weights[i];
      if (location.weights[i] < least) {
        least = location.weights[i];
        across = i;
      }
    }
    if (across == 3 || least > -1e-12 * sum) {
      for (double& weight : location.weights) weight = std::max(weight / sum, 0.0);
      return location;
    }
    triangle = here.neighbours[across];
    if (triangle < 0) return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace collinea
