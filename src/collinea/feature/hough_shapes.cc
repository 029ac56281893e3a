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
constexpr double kCell = 2;            // of the votes [px]
constexpr double kNormalCosine = 0.9;  // between the gradients of the shape and of the image
constexpr int kPeaksOfOne = 5;         // looked at of each rotation and scale
constexpr int kIterations = 15;

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
                    std::vector<Candidate>& out) {
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
    if (best.votes <= 0) return;
    best.votes /= scale;
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

struct Unknowns {
  bool rotation = false, scale = false;
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
    if (!(found.scale > 0) || (found.at - start.at).norm() > 0.5 * shape.radius_px() + 10) return std::nullopt;
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

std::vector<FoundShape> hough_shapes(const EdgePoints& edges, const ShapeTable& shape, const ShapeSearch& search,
                                     const HoughOptions& options) {
  std::vector<Candidate> candidates;
  for (const double rotation : search.rotations_rad)
    for (const double scale : search.scales) add_candidates(edges, shape, rotation, scale, candidates);
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.votes > b.votes; });
  if (candidates.size() > std::size_t(5 * options.most)) candidates.resize(std::size_t(5 * options.most));
  const Nearest nearest(edges);
  const Unknowns unknowns{search.rotations_rad.size() > 1, search.scales.size() > 1};
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
