// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace collinea {
namespace {

constexpr int kCells = 8;  // the image is divided into kCells x kCells for the judgement of coverage
constexpr int kSides = 4;  // directions a neighbour may lie in
constexpr std::size_t kSharedToCompare = 8;
constexpr int kFewestShared = 6;
constexpr double kLeastWorth = 0.05;  // 0.3 degrees

struct Candidate {
  ImageId image;
  int shared = 0;
  int side = 0;
  std::array<double, kCells * kCells> worth{};  // per cell, in [0, 1]
};

// How useful rays at this angle are: below 6 degrees depth is weak, above 25 the pictures grow too different.
double worth_of_angle(double angle_rad) {
  const double deg = angle_rad * 180 / std::numbers::pi;
  if (deg < 6) return deg / 6;
  return deg < 25 ? 1 : std::exp(-std::pow((deg - 25) / 12, 2));
}

double angle_at(const Eigen::Vector3d& point, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d u = a - point, v = b - point;
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

int cell_of(const Camera& camera, const Eigen::Vector2d& pixel) {
  const int i = std::clamp(int(pixel.x() / camera.width_px * kCells), 0, kCells - 1);
  const int j = std::clamp(int(pixel.y() / camera.height_px * kCells), 0, kCells - 1);
  return j * kCells + i;
}

int side_of(const Eigen::Vector3d& base_in_cam) {
  const double turn = std::atan2(base_in_cam.y(), base_in_cam.x()) / (2 * std::numbers::pi) + 1;
  return int(std::floor(turn * kSides + 0.5)) % kSides;
}

// Takes, again and again, the candidate that adds most to what is covered already.
std::vector<ImageId> most_useful(std::vector<Candidate> candidates, int count) {
  std::array<double, kCells * kCells> covered{};
  std::array<std::array<double, kCells * kCells>, kSides> covered_from{};
  std::vector<ImageId> chosen;
  while (int(chosen.size()) < count && !candidates.empty()) {
    const auto gain = [&](const Candidate& c) {
      double sum = 0;
      for (std::size_t i = 0; i < c.worth.size(); ++i)
        sum += c.worth[i] / (1 + 0.5 * covered[i] + covered_from[std::size_t(c.side)][i]);
      return sum;
    };
    const auto best = std::max_element(candidates.begin(), candidates.end(),
                                       [&](const Candidate& a, const Candidate& b) { return gain(a) < gain(b); });
    for (std::size_t i = 0; i < covered.size(); ++i) {
      covered[i] += best->worth[i];
      covered_from[std::size_t(best->side)][i] += best->worth[i];
    }
    chosen.push_back(best->image);
    candidates.erase(best);
  }
  return chosen;
}

}  // namespace

TieView::TieView(const Block& block) : block_(block) {
  for (const auto& [id, point] : block.points) add(id, point.position_in_world);
  for (const Observation& seen : block.observations) add(seen);
  finish();
}

TieView TieView::without_ties(const Block& block) { return {block, Nothing{}}; }

void TieView::add(PointId id, const Eigen::Vector3d& position_in_world) {
  points_.push_back(id);
  positions_.push_back(position_in_world);
}

void TieView::add(const Observation& seen) {
  // first_ray_ grows up to the point of this ray: observations are sorted by point.
  std::size_t point = first_ray_.empty() ? 0 : first_ray_.size() - 1;
  while (point < points_.size() && points_[point] < seen.point) ++point;
  if (point == points_.size() || points_[point] != seen.point || !block_.cam_from_world.count(seen.image)) return;
  const auto ray = std::uint32_t(image_of_ray_.size());
  first_ray_.resize(point + 1, ray);
  rays_of_[seen.image].push_back(ray);
  image_of_ray_.push_back(seen.image);
  cell_of_ray_.push_back(std::uint8_t(cell_of(block_.camera_of(seen.image), seen.pixel)));
}

void TieView::finish() {
  first_ray_.resize(points_.size() + 1, std::uint32_t(image_of_ray_.size()));
  points_.shrink_to_fit();
  positions_.shrink_to_fit();
  first_ray_.shrink_to_fit();
  image_of_ray_.shrink_to_fit();
  cell_of_ray_.shrink_to_fit();
  for (auto& [image, rays] : rays_of_) rays.shrink_to_fit();
}

std::size_t TieView::point_of(std::uint32_t ray) const {
  return std::size_t(std::upper_bound(first_ray_.begin(), first_ray_.end(), ray) - first_ray_.begin()) - 1;
}

std::vector<SeenPoint> TieView::seen_by(ImageId image) const {
  std::vector<SeenPoint> seen;
  const auto own = rays_of_.find(image);
  if (own == rays_of_.end()) return seen;
  const Rigid3& cam_from_world = block_.cam_from_world.at(image);
  for (const std::uint32_t ray : own->second) {
    const std::size_t point = point_of(ray);
    const Eigen::Vector3d in_cam = cam_from_world * positions_[point];
    if (in_cam.z() > 0) seen.push_back({in_cam, points_[point]});
  }
  return seen;
}

std::vector<ImageId> TieView::neighbours(ImageId image, int count) const {
  const auto own = rays_of_.find(image);
  if (own == rays_of_.end()) return {};
  const Rigid3& cam_from_world = block_.cam_from_world.at(image);
  const Eigen::Vector3d centre = centre_of(cam_from_world);

  std::array<double, kCells * kCells> points_in_cell{};
  std::map<ImageId, Candidate> candidates;
  for (const std::uint32_t mine : own->second) {
    const std::size_t point = point_of(mine);
    const std::size_t cell = cell_of_ray_[mine];
    ++points_in_cell[cell];
    for (std::uint32_t ray = first_ray_[point]; ray < first_ray_[point + 1]; ++ray) {
      const ImageId other = image_of_ray_[ray];
      if (other == image) continue;
      Candidate& c = candidates[other];
      c.image = other;
      ++c.shared;
      c.worth[cell] += worth_of_angle(angle_at(positions_[point], centre, centre_of(block_.cam_from_world.at(other))));
    }
  }

  std::vector<Candidate> list;
  for (auto& [id, c] : candidates) {
    if (c.shared < int(std::min(kSharedToCompare, own->second.size() / 4))) continue;
    if (std::accumulate(c.worth.begin(), c.worth.end(), 0.0) < kLeastWorth * c.shared) continue;
    for (std::size_t i = 0; i < c.worth.size(); ++i) c.worth[i] /= std::max(1.0, points_in_cell[i]);
    c.side = side_of(cam_from_world * centre_of(block_.cam_from_world.at(id)));
    list.push_back(c);
  }
  return most_useful(std::move(list), count);
}

std::vector<ImageId> TieView::overlapping(ImageId image, int count) const {
  const auto own = rays_of_.find(image);
  if (own == rays_of_.end()) return {};
  std::map<ImageId, int> shared;
  for (const std::uint32_t mine : own->second) {
    const std::size_t point = point_of(mine);
    for (std::uint32_t ray = first_ray_[point]; ray < first_ray_[point + 1]; ++ray)
      if (ray != mine) ++shared[image_of_ray_[ray]];
  }
  std::vector<std::pair<int, ImageId>> order;
  for (const auto& [id, n] : shared)
    if (id != image && n >= kFewestShared) order.emplace_back(-n, id);
  std::sort(order.begin(), order.end());
  std::vector<ImageId> result;
  for (std::size_t i = 0; i < order.size() && int(i) < count; ++i) result.push_back(order[i].second);
  return result;
}

}  // namespace collinea
