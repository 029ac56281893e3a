// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/coverage.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kSteepest = 0.26;  // cosine of 75 degrees from the nadir: beyond, footprints run to infinity

double median_height(const Block& block) {
  std::vector<double> heights;
  heights.reserve(block.points.size());
  for (const auto& [id, point] : block.points) heights.push_back(point.position_in_world.z());
  return heights.empty() ? 0 : median(heights);
}

// Empty when a corner does not look down.
Polygon corners_on_ground(const Camera& camera, const Rigid3& cam_from_world, double height) {
  constexpr int kPerSide = 4;  // distortion bends the sides
  const double w = camera.width_px, h = camera.height_px;
  const std::array<Eigen::Vector2d, 5> corners = {{{0, 0}, {w, 0}, {w, h}, {0, h}, {0, 0}}};
  const Eigen::Vector3d centre = centre_of(cam_from_world);
  Polygon polygon;
  for (std::size_t side = 0; side < 4; ++side)
    for (int step = 0; step < kPerSide; ++step) {
      const double t = double(step) / kPerSide;
      const Eigen::Vector2d pixel = (1 - t) * corners[side] + t * corners[side + 1];
      const Eigen::Vector3d ray = cam_from_world.rotation.conjugate() * ray_in_cam(camera, pixel);
      const double drop = height - centre.z();
      if (!(ray.z() * drop > 0) || std::abs(ray.z()) < kSteepest) return {};
      polygon.push_back((centre + ray * (drop / ray.z())).head<2>());
    }
  return polygon;
}

double turn(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

// Andrew's monotone chain.
Polygon hull_of(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return a.x() < b.x() || (a.x() == b.x() && a.y() < b.y()); });
  if (points.size() < 3) return {};
  Polygon hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t first = hull.size();
    for (const auto& point : points) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0) hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

// The horizon behind a scene would make a footprint of its own.
void leave_out_far(std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& centre) {
  constexpr double kFar = 2;  // times the median distance
  if (points.empty()) return;
  std::vector<double> distances;
  for (const auto& point : points) distances.push_back((point - centre).norm());
  const double far = kFar * median(distances);
  std::erase_if(points, [&](const auto& point) { return (point - centre).norm() > far; });
}

bool contains(const Polygon& polygon, const Eigen::Vector2d& p) {
  bool inside = false;
  for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const auto &a = polygon[i], &b = polygon[j];
    if ((a.y() > p.y()) != (b.y() > p.y()) && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
      inside = !inside;
  }
  return inside;
}

void count_image(const Polygon& polygon, Overlap& overlap) {
  Eigen::Vector2d low = polygon[0], high = low;
  for (const auto& p : polygon) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  const auto cell = [&](double value, double origin, int cells) {
    return int(std::clamp((value - origin) / overlap.cell, 0.0, double(cells)));
  };
  const int first_row = cell(low.y(), overlap.lower_left.y(), overlap.rows);
  const int last_row = std::min(overlap.rows - 1, cell(high.y(), overlap.lower_left.y(), overlap.rows));
  const int first_column = cell(low.x(), overlap.lower_left.x(), overlap.columns);
  const int last_column = std::min(overlap.columns - 1, cell(high.x(), overlap.lower_left.x(), overlap.columns));
  for (int row = first_row; row <= last_row; ++row)
    for (int column = first_column; column <= last_column; ++column) {
      const Eigen::Vector2d centre = overlap.lower_left + overlap.cell * Eigen::Vector2d(column + 0.5, row + 0.5);
      overlap.images[std::size_t(row * overlap.columns + column)] += contains(polygon, centre);
    }
}

}  // namespace

Coverage coverage_of(const Block& block) {
  Coverage coverage{median_height(block), {}};
  std::map<ImageId, std::vector<Eigen::Vector2d>> sideways;
  for (const auto& [id, pose] : oriented_images(block)) {
    Polygon polygon = corners_on_ground(block.camera_of(id), pose, coverage.ground_height);
    if (polygon.empty())
      sideways[id];
    else
      coverage.footprints[id] = std::move(polygon);
  }
  for (const Observation& o : block.observations) {
    const auto image = sideways.find(o.image);
    const auto point = block.points.find(o.point);
    if (image != sideways.end() && point != block.points.end())
      image->second.push_back(point->second.position_in_world.head<2>());
  }
  for (auto& [id, points] : sideways) leave_out_far(points, centre_of(pose_of(block, id)).head<2>());
  for (auto& [id, points] : sideways)
    if (Polygon hull = hull_of(std::move(points)); hull.size() >= 3) coverage.footprints[id] = std::move(hull);
  return coverage;
}

Overlap overlap_of(const Coverage& coverage, int longest_side_cells) {
  Overlap overlap;
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  for (const auto& [id, polygon] : coverage.footprints)
    for (const auto& p : polygon) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  if (!low.allFinite() || !(high - low).allFinite() || !((high - low).maxCoeff() > 0)) return overlap;
  overlap.lower_left = low;
  overlap.cell = (high - low).maxCoeff() / longest_side_cells;
  overlap.columns = std::max(1, int(std::ceil((high - low).x() / overlap.cell)));
  overlap.rows = std::max(1, int(std::ceil((high - low).y() / overlap.cell)));
  overlap.images.assign(std::size_t(overlap.columns) * std::size_t(overlap.rows), 0);
  for (const auto& [id, polygon] : coverage.footprints) count_image(polygon, overlap);
  return overlap;
}

double Overlap::area(int at_least) const {
  const auto cells = std::count_if(images.begin(), images.end(), [&](int n) { return n >= at_least; });
  return double(cells) * cell * cell;
}

}  // namespace collinea
