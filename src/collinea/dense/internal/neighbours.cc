// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/neighbours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include "collinea/base/packed.h"

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

// How useful rays at this angle are: below 6 degrees depth is weak, above 25 the images grow too different.
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

// One ray of an image: the point, and who else sees it.
struct TieView::Ray {
  Eigen::Vector3d point_in_world;
  std::size_t cell;             // of its image, where the ray lies
  std::vector<ImageId> others;  // images of the other rays to the point
};

TieView::TieView(const Block& block) : block_(&block) {
  auto observation = block.observations.begin();
  const auto end = block.observations.end();
  for (const auto& [id, point] : block.points) {
    while (observation != end && observation->point < id) ++observation;
    const auto first = observation;
    while (observation != end && observation->point == id) ++observation;
    add(point.position_in_world, {first, observation});
  }
}

Result<TieView> TieView::on_disk(const Block& block, const std::filesystem::path& file) {
  TieView view(&block);
  COLLINEA_TRY(view.spool_, RecordSpool::create(file));
  return view;
}

void TieView::add(const Eigen::Vector3d& position_in_world, std::span<const Observation> observations) {
  const auto passed_over = [&](const Observation& seen) { return !is_oriented(*block_, seen.image); };
  const auto images = std::uint32_t(observations.size()) -
                      std::uint32_t(std::count_if(observations.begin(), observations.end(), passed_over));
  for (const Observation& own : observations) {
    if (passed_over(own)) continue;
    Packer packer;
    for (int i = 0; i < 3; ++i) packer.put(position_in_world[i]);
    packer.put(std::uint8_t(cell_of(block_->camera_of(own.image), own.pixel)));
    packer.put(images - 1);
    for (const Observation& other : observations)
      if (&other != &own && !passed_over(other)) packer.put(other.image.value);
    rays_[own.image].in_memory += packer.bytes();
    buffered_ += packer.size();
  }
  if (spool_ && buffered_ > kBuffered) move_to_disk();
}

void TieView::move_to_disk() {
  for (auto& [image, rays] : rays_) {
    if (rays.in_memory.empty()) continue;
    Packer before;
    before.put(rays.last.at);
    before.put(rays.last.bytes);
    rays.last = {spool_->size(), before.size() + rays.in_memory.size()};
    spool_->append(before.bytes());
    spool_->append(rays.in_memory);
    std::string().swap(rays.in_memory);
  }
  buffered_ = 0;
}

std::size_t TieView::bytes_in_memory() const {
  std::size_t bytes = rays_.size() * sizeof(Rays);
  for (const auto& [image, rays] : rays_) bytes += rays.in_memory.capacity();
  return bytes;
}

Result<std::string> TieView::rays_of(ImageId image) const {
  const auto own = rays_.find(image);
  if (own == rays_.end()) return std::string();
  std::vector<std::string> pieces;  // last first
  std::size_t bytes = own->second.in_memory.size();
  for (Piece piece = own->second.last; piece.at != kNone;) {
    COLLINEA_TRY(pieces.emplace_back(), spool_->read(piece.at, piece.bytes));
    Unpacker before(pieces.back());
    before.get(piece.at);
    before.get(piece.bytes);
    bytes += before.left();
  }
  std::string rays;
  rays.reserve(bytes);
  for (; !pieces.empty(); pieces.pop_back()) rays.append(pieces.back(), sizeof(Piece));
  return rays += own->second.in_memory;
}

template <class Visit>
Result<> TieView::for_rays(ImageId image, Visit&& visit) const {
  COLLINEA_TRY(const std::string bytes, rays_of(image));
  Unpacker unpacker(bytes);
  Ray ray;
  while (unpacker.left() > 0) {
    for (int i = 0; i < 3; ++i) unpacker.get(ray.point_in_world[i]);
    ray.cell = unpacker.get<std::uint8_t>();
    ray.others.resize(unpacker.get<std::uint32_t>());
    for (ImageId& other : ray.others) unpacker.get(other.value);
    visit(std::as_const(ray));
  }
  return {};
}

Result<std::vector<Eigen::Vector3d>> TieView::seen_by(ImageId image) const {
  std::vector<Eigen::Vector3d> seen;
  auto read = for_rays(image, [&](const Ray& ray) {
    const Eigen::Vector3d in_cam = pose_of(*block_, image) * ray.point_in_world;
    if (in_cam.z() > 0) seen.push_back(in_cam);
  });
  if (!read) return tl::unexpected(std::move(read).error());
  return seen;
}

Result<std::vector<ImageId>> TieView::neighbours(ImageId image, int count) const {
  std::size_t rays = 0;
  std::array<double, kCells * kCells> points_in_cell{};
  std::map<ImageId, Candidate> candidates;
  auto read = for_rays(image, [&](const Ray& ray) {
    const Eigen::Vector3d centre = centre_of(pose_of(*block_, image));
    ++rays;
    ++points_in_cell[ray.cell];
    for (const ImageId other : ray.others) {
      if (other == image) continue;
      Candidate& c = candidates[other];
      c.image = other;
      ++c.shared;
      c.worth[ray.cell] += worth_of_angle(angle_at(ray.point_in_world, centre, centre_of(pose_of(*block_, other))));
    }
  });
  if (!read) return tl::unexpected(std::move(read).error());

  std::vector<Candidate> list;
  for (auto& [id, c] : candidates) {
    if (c.shared < int(std::min(kSharedToCompare, rays / 4))) continue;
    if (std::accumulate(c.worth.begin(), c.worth.end(), 0.0) < kLeastWorth * c.shared) continue;
    for (std::size_t i = 0; i < c.worth.size(); ++i) c.worth[i] /= std::max(1.0, points_in_cell[i]);
    c.side = side_of(pose_of(*block_, image) * centre_of(pose_of(*block_, id)));
    list.push_back(c);
  }
  return most_useful(std::move(list), count);
}

Result<std::vector<ImageId>> TieView::overlapping(ImageId image, int count) const {
  std::map<ImageId, int> shared;
  auto read = for_rays(image, [&](const Ray& ray) {
    for (const ImageId other : ray.others) ++shared[other];
  });
  if (!read) return tl::unexpected(std::move(read).error());
  std::vector<std::pair<int, ImageId>> order;
  for (const auto& [id, n] : shared)
    if (id != image && n >= kFewestShared) order.emplace_back(-n, id);
  std::sort(order.begin(), order.end());
  std::vector<ImageId> result;
  for (std::size_t i = 0; i < order.size() && int(i) < count; ++i) result.push_back(order[i].second);
  return result;
}

}  // namespace collinea
