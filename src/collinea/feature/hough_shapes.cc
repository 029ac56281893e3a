// SPDX-License-Identifier: Apache-2.0
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/feature/hough.h"

namespace collinea {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kTurn = 2 * std::numbers::pi;
constexpr double kCell = 2;  // of the votes [px]
constexpr double kStep = 4;  // by which a point of the shape moves from one rotation or scale to the next [px]
constexpr double kNormalCosine = 0.9;  // between the gradients of the shape and of the image
constexpr int kPeaksOfOne = 5;         // looked at of each rotation and scale
constexpr int kIterations = 15;
constexpr double kLeastVotes = 0.5;   // of those that the least share of the shape would make
constexpr double kLeastLever = 0.05;  // of rotation; the normals of edge points are not better than that [rad]

Matrix2d turned(double angle_rad) {
  Matrix2d out;
  out << std::cos(angle_rad), -std::sin(angle_rad), std::sin(angle_rad), std::cos(angle_rad);
  return out;
}

struct Candidate {
  Vector2d at;
  double rotation_rad = 0, scale = 1, votes = 0;
};

// Where the reference point may be, for one rotation and scale.
void add_candidates(const EdgePoints& edges, const ShapeTable& shape, double rotation_rad, double scale,
                    double least_votes, std::vector<Candidate>& out) {
  Raster<float> votes(int(edges.width / kCell) + 1, int(edges.height / kCell) + 1);
  const Matrix2d turn = scale * turned(rotation_rad);
  for (const EdgePoint& p : edges.points)
    for (const std::size_t e : shape.at_direction(std::atan2(p.normal.y(), p.normal.x()) - rotation_rad)) {
      const Vector2d cell = (p.at - turn * shape.entries()[e].from_reference) / kCell;
      if (cell.x() >= 0 && cell.y() >= 0 && cell.x() < votes.width && cell.y() < votes.height)
        votes.at(int(cell.x()), int(cell.y())) += 1;
    }
  for (int k = 0; k < kPeaksOfOne; ++k) {
    Candidate best;
    int bx = 0, by = 0;
    for (int y = 1; y + 1 < votes.height; ++y)
      for (int x = 1; x + 1 < votes.width; ++x) {
        double sum = 0;
        for (int d = 0; d < 9; ++d) sum += votes.at(x + d % 3 - 1, y + d / 3 - 1);
        if (sum <= best.votes) continue;
        best = {Vector2d((x + 0.5) * kCell, (y + 0.5) * kCell), rotation_rad, scale, sum};
        bx = x;
        by = y;
      }
    best.votes /= scale;
    if (!(best.votes >= least_votes)) return;
    out.push_back(best);
    for (int d = 0; d < 25; ++d)
      if (const int x = bx + d % 5 - 2, y = by + d / 5 - 2; x >= 0 && y >= 0 && x < votes.width && y < votes.height)
        votes.at(x, y) = 0;
  }
}

// For each point of the shape the nearest of the image, in cells.
class Nearest {
 public:
  explicit Nearest(const EdgePoints& edges) : edges_(edges), cells_(edges.width, edges.height) {
    for (std::size_t i = 0; i < edges.points.size(); ++i) {
      const Vector2d& p = edges.points[i].at;
      const int x = std::clamp(int(p.x()), 0, edges.width - 1), y = std::clamp(int(p.y()), 0, edges.height - 1);
      cells_.at(x, y) = std::uint32_t(i + 1);
    }
  }
  [[nodiscard]] const EdgePoint* operator()(const Vector2d& p, const Vector2d& normal, double reach_px) const {
    const EdgePoint* best = nullptr;
    double nearest = reach_px;
    const int r = int(std::ceil(reach_px));
    for (int y = std::max(0, int(p.y()) - r); y <= std::min(cells_.height - 1, int(p.y()) + r); ++y)
      for (int x = std::max(0, int(p.x()) - r); x <= std::min(cells_.width - 1, int(p.x()) + r); ++x) {
        if (!cells_.at(x, y)) continue;
        const EdgePoint& point = edges_.points[cells_.at(x, y) - 1];
        const double distance = (point.at - p).norm();
        if (distance > nearest || point.normal.dot(normal) < kNormalCosine) continue;
        nearest = distance;
        best = &point;
      }
    return best;
  }

 private:
  const EdgePoints& edges_;
  Raster<std::uint32_t> cells_;
};

// What is adjusted, and how far: a step beyond what was searched, else a shape shrinks onto a single edge.
struct Unknowns {
  bool rotation = false, scale = false;
  double smallest_scale = 1, largest_scale = 1;

  explicit Unknowns(const ShapeSearch& search)
      : rotation(search.rotations_rad.size() > 1), scale(search.scales.size() > 1) {
    if (!scale) return;
    const auto [low, high] = std::minmax_element(search.scales.begin(), search.scales.end());
    const double step = std::pow(*high / *low, 1 / double(search.scales.size() - 1));
    smallest_scale = *low / step;
    largest_scale = *high * step;
  }
  [[nodiscard]] int count() const { return 2 + rotation + scale; }
};

std::optional<EdgeStep> step_of(const Nearest& nearest, const ShapeTable& shape, const Unknowns& unknowns,
                                double along_px, double reach_px, FoundShape& found) {
  const Matrix2d turn = turned(found.rotation_rad);
  std::vector<EdgePoint> points;
  std::vector<Vector2d> offsets;
  for (const ShapeTable::Entry& entry : shape.entries()) {
    const Vector2d offset = found.scale * (turn * entry.from_reference);
    if (const EdgePoint* p = nearest(found.at + offset, turn * entry.normal, reach_px)) {
      points.push_back(*p);
      offsets.push_back(offset);
    }
  }
  found.share = double(points.size()) / double(shape.entries().size());
  Eigen::MatrixXd design(Eigen::Index(points.size()), unknowns.count());
  Eigen::VectorXd misclosure(design.rows());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Vector2d& n = points[i].normal;
    const auto row = Eigen::Index(i);
    misclosure[row] = n.dot(points[i].at - found.at - offsets[i]);
    design.row(row).head<2>() = n.transpose();
    int k = 2;
    if (unknowns.rotation) design(row, k++) = n.dot(Vector2d(-offsets[i].y(), offsets[i].x()));
    if (unknowns.scale) design(row, k++) = n.dot(offsets[i]) / found.scale;
  }
  if (unknowns.rotation) {
    double reach = 0;
    for (const Vector2d& offset : offsets) reach += offset.squaredNorm();
    if (!(design.col(2).squaredNorm() > kLeastLever * kLeastLever * reach)) return std::nullopt;
  }
  return adjust_edge_points(points, along_px, design, misclosure);
}

std::optional<FoundShape> adjusted(const EdgePoints& edges, const Nearest& nearest, const ShapeTable& shape,
                                   const Candidate& start, const Unknowns& unknowns, double tolerance_px) {
  FoundShape found{.at = start.at, .rotation_rad = start.rotation_rad, .scale = start.scale};
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const double reach = tolerance_px + std::max(0.0, 4.0 - iteration);
    const auto step = step_of(nearest, shape, unknowns, edges.along_px, reach, found);
    if (!step) return std::nullopt;
    found.at += step->correction.head<2>();
    int k = 2;
    if (unknowns.rotation) found.rotation_rad += step->correction[k++];
    if (unknowns.scale) found.scale += step->correction[k++];
    if (unknowns.scale && !(found.scale >= unknowns.smallest_scale && found.scale <= unknowns.largest_scale))
      return std::nullopt;
    if ((found.at - start.at).norm() > 0.5 * shape.radius_px() + 10) return std::nullopt;
    found.covariance = step->covariance;
    found.quality = step->quality;
    if (iteration > 5 && step->correction.norm() < 1e-6) break;
  }
  found.rotation_rad = std::remainder(found.rotation_rad, kTurn);
  return found;
}

}  // namespace

std::optional<ShapeTable> ShapeTable::create(std::span<const EdgePoint> shape, const Vector2d& reference) {
  if (shape.size() < 5) return std::nullopt;
  ShapeTable out;
  for (const EdgePoint& p : shape) {
    out.entries_.push_back({p.at - reference, p.normal});
    out.radius_px_ = std::max(out.radius_px_, (p.at - reference).norm());
    const double bin = std::atan2(p.normal.y(), p.normal.x()) / kTurn * kBins;
    for (int k = -1; k <= 1; ++k)
      out.bins_[std::size_t((int(std::floor(bin)) + k + 2 * kBins) % kBins)].push_back(out.entries_.size() - 1);
  }
  return out;
}

std::span<const std::size_t> ShapeTable::at_direction(double angle_rad) const {
  const int bin = int(std::floor(std::remainder(angle_rad, kTurn) / kTurn * kBins));
  return bins_[std::size_t((bin + 2 * kBins) % kBins)];
}

ShapeSearch shape_search(const ShapeTable& shape, double largest_rotation_rad, double smallest_scale,
                         double largest_scale) {
  ShapeSearch out;
  const double radius = std::max(shape.radius_px() * largest_scale, 1.0);
  if (largest_rotation_rad > 0) {
    const double largest = std::min(largest_rotation_rad, kTurn / 2);
    const int steps = std::max(1, int(std::ceil(largest * radius / kStep)));
    out.rotations_rad.clear();
    for (int k = -steps; k <= steps; ++k) out.rotations_rad.push_back(largest * k / steps);
    if (largest == kTurn / 2) out.rotations_rad.pop_back();  // the same as the first
  }
  if (largest_scale > smallest_scale) {
    const double range = std::log(largest_scale / smallest_scale);
    const int steps = std::max(1, int(std::ceil(range / std::log1p(kStep / radius))));
    out.scales.clear();
    for (int k = 0; k <= steps; ++k) out.scales.push_back(smallest_scale * std::exp(range * k / steps));
  } else {
    out.scales = {smallest_scale};
  }
  return out;
}

std::vector<FoundShape> hough_shapes(const EdgePoints& edges, const ShapeTable& shape, const ShapeSearch& search,
                                     const HoughOptions& options) {
  std::vector<Candidate> candidates;
  const double least_votes = std::max(1.0, kLeastVotes * search.least_share * double(shape.entries().size()));
  for (const double rotation : search.rotations_rad)
    for (const double scale : search.scales) add_candidates(edges, shape, rotation, scale, least_votes, candidates);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.votes > b.votes; });
  if (candidates.size() > std::size_t(5 * options.most)) candidates.resize(std::size_t(5 * options.most));
  const Nearest nearest(edges);
  const Unknowns unknowns(search);
  std::vector<FoundShape> out;
  for (const Candidate& candidate : candidates) {
    auto found = adjusted(edges, nearest, shape, candidate, unknowns, options.tolerance_px);
    if (found && found->share >= search.least_share) out.push_back(std::move(*found));
  }
  std::stable_sort(out.begin(), out.end(), [](const FoundShape& a, const FoundShape& b) { return a.share > b.share; });
  std::vector<FoundShape> best;  // one at each position
  for (FoundShape& found : out) {
    const bool is_new = std::none_of(best.begin(), best.end(), [&](const FoundShape& b) {
      return (b.at - found.at).norm() < std::max(3.0, 0.3 * shape.radius_px());
    });
    if (is_new && best.size() < std::size_t(options.most)) best.push_back(std::move(found));
  }
  return best;
}

}  // namespace collinea
