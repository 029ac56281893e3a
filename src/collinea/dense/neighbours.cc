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
  for (std::size_t i = 0; i < block.observations.size(); ++i)
    if (block.cam_from_world.count(block.observations[i].image) && block.points.count(block.observations[i].point))
      observations_of_[block.observations[i].image].push_back(std::uint32_t(i));
}

std::vector<SeenPoint> TieView::seen_by(ImageId image) const {
  std::vector<SeenPoint> seen;
  const auto own = observations_of_.find(image);
  if (own == observations_of_.end()) return seen;
  const Rigid3& cam_from_world = block_.cam_from_world.at(image);
  for (const std::uint32_t index : own->second) {
    const PointId point = block_.observations[index].point;
    const Eigen::Vector3d in_cam = cam_from_world * block_.points.at(point).position_in_world;
    if (in_cam.z() > 0) seen.push_back({in_cam, point});
  }
  return seen;
}

std::vector<ImageId> TieView::neighbours(ImageId image, int count) const {
  const auto own = observations_of_.find(image);
  if (own == observations_of_.end()) return {};
  const Rigid3& cam_from_world = block_.cam_from_world.at(image);
  const Eigen::Vector3d centre = centre_of(cam_from_world);
  const Camera& camera = block_.camera_of(image);

  std::array<double, kCells * kCells> points_in_cell{};
  std::map<ImageId, Candidate> candidates;
  for (const std::uint32_t index : own->second) {
    const Observation& mine = block_.observations[index];
    const Eigen::Vector3d& position = block_.points.at(mine.point).position_in_world;
    const int cell = cell_of(camera, mine.pixel);
    ++points_in_cell[std::size_t(cell)];
    // observations are sorted by point: the other rays of this point lie around index
    const auto add = [&](const Observation& other) {
      const auto pose = block_.cam_from_world.find(other.image);
      if (other.image == image || pose == block_.cam_from_world.end()) return;
      Candidate& c = candidates[other.image];
      c.image = other.image;
      ++c.shared;
      c.worth[std::size_t(cell)] += worth_of_angle(angle_at(position, centre, centre_of(pose->second)));
    };
    for (std::size_t i = index; i-- > 0 && block_.observations[i].point == mine.point;) add(block_.observations[i]);
    for (std::size_t i = index + 1; i < block_.observations.size() && block_.observations[i].point == mine.point; ++i)
      add(block_.observations[i]);
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
  const auto own = observations_of_.find(image);
  if (own == observations_of_.end()) return {};
  std::map<ImageId, int> shared;
  for (const std::uint32_t index : own->second) {
    const PointId point = block_.observations[index].point;
    for (std::size_t i = index; i-- > 0 && block_.observations[i].point == point;)
      ++shared[block_.observations[i].image];
    for (std::size_t i = index + 1; i < block_.observations.size() && block_.observations[i].point == point; ++i)
      ++shared[block_.observations[i].image];
  }
  std::vector<std::pair<int, ImageId>> order;
  for (const auto& [id, n] : shared)
    if (id != image && n >= kFewestShared && block_.cam_from_world.count(id)) order.emplace_back(-n, id);
  std::sort(order.begin(), order.end());
  std::vector<ImageId> result;
  for (std::size_t i = 0; i < order.size() && int(i) < count; ++i) result.push_back(order[i].second);
  return result;
}

}  // namespace collinea
