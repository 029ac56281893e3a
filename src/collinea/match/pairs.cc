// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

#include "collinea/match/internal/position_tree.h"

namespace collinea {
namespace {

constexpr int kSectors = 8;
constexpr int kPerSector = 2;
constexpr std::size_t kSectorReach = 128;  // nearest images among which a sector looks
constexpr double kFlattest_deg = -15;      // of the optical axis: farther out a degree is a footprint's size

class PairSet {
 public:
  void add(ImageId a, ImageId b) {
    if (a != b) pairs_.emplace(std::min(a, b), std::max(a, b));
  }
  [[nodiscard]] std::vector<ImageIdPair> sorted() const { return {pairs_.begin(), pairs_.end()}; }

 private:
  std::set<ImageIdPair> pairs_;
};

// File names in an order in which 9 comes before 10: runs of digits compare as numbers.
bool comes_before(const std::string& a, const std::string& b) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      std::size_t i_end = i, j_end = j;
      while (i_end < a.size() && is_digit(a[i_end])) ++i_end;
      while (j_end < b.size() && is_digit(b[j_end])) ++j_end;
      while (i < i_end && a[i] == '0') ++i;
      while (j < j_end && b[j] == '0') ++j;
      if (i_end - i != j_end - j) return i_end - i < j_end - j;
      const int order = a.compare(i, i_end - i, b, j, j_end - j);
      if (order != 0) return order < 0;
      i = i_end;
      j = j_end;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (i < a.size() || j < b.size()) return i >= a.size();
  return a < b;
}

std::vector<ImageId> in_order_of_taking(const Block& setup) {
  std::vector<ImageId> order;
  for (const auto& [id, image] : setup.images) order.push_back(id);
  const bool timed = std::ranges::none_of(setup.images, [](const auto& entry) { return entry.second.taken.empty(); });
  std::ranges::stable_sort(order, [&](ImageId a, ImageId b) {
    const Image &one = setup.images.at(a), &other = setup.images.at(b);
    if (timed && one.taken != other.taken) return one.taken < other.taken;
    return comes_before(one.file, other.file);
  });
  return order;
}

void add_sequence(const Block& setup, const PairOptions& options, PairSet& pairs) {
  const std::vector<ImageId> order = in_order_of_taking(setup);
  const auto overlap = static_cast<std::size_t>(std::max(0, options.sequence_overlap));
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t step = 1; step <= overlap && i + step < order.size(); ++step) pairs.add(order[i], order[i + step]);
    if (setup.images.at(order[i]).position || overlap == 0) continue;
    for (std::size_t step = 2 * overlap; step < order.size(); step *= 2) {
      if (i + step < order.size()) pairs.add(order[i], order[i + step]);
      if (i >= step) pairs.add(order[i], order[i - step]);
    }
  }
}

struct Stations {
  std::vector<ImageId> images;
  std::vector<Eigen::Vector3d> positions_m;
};

void add_nearest(const Stations& stations, std::size_t count, PairSet& pairs) {
  const PositionTree tree(stations.positions_m);
  for (std::uint32_t i = 0; i < stations.images.size(); ++i)
    for (const PositionTree::Neighbour& other : tree.nearest(i, count))
      pairs.add(stations.images[i], stations.images[other.index]);
}

// Dense strips fill the list of the nearest with images of the strip itself.
void add_by_sector(const Stations& stations, PairSet& pairs) {
  const PositionTree tree(stations.positions_m);
  for (std::uint32_t i = 0; i < stations.images.size(); ++i) {
    std::array<int, kSectors> taken{};
    for (const PositionTree::Neighbour& other : tree.nearest(i, kSectorReach)) {
      const Eigen::Vector3d step_m = stations.positions_m[other.index] - stations.positions_m[i];
      const double turns = std::atan2(step_m.y(), step_m.x()) / (2 * std::numbers::pi) + 1;
      int& count = taken[static_cast<std::size_t>(std::lround(turns * kSectors)) % kSectors];
      if (count++ < kPerSector) pairs.add(stations.images[i], stations.images[other.index]);
    }
  }
}

// Where the optical axis meets the ground. Nothing without height, or when that is too far away to mean anything.
std::optional<Eigen::Vector3d> looked_at(const Image& image, const PairOptions& options) {
  const std::optional<double> height_m =
      options.height_above_ground_m ? options.height_above_ground_m : image.position->height_above_start_m;
  if (!image.attitude || !height_m || *height_m <= 0 || image.attitude->pitch_deg > kFlattest_deg) return std::nullopt;
  constexpr double kRadians = std::numbers::pi / 180;
  const double heading = image.attitude->heading_deg * kRadians;
  const double forward_m = *height_m / std::tan(-image.attitude->pitch_deg * kRadians);
  return image.position->position_in_world +
         Eigen::Vector3d(std::sin(heading) * forward_m, std::cos(heading) * forward_m, -*height_m);
}

void add_by_position(const Block& setup, const PairOptions& options, PairSet& pairs) {
  Stations stations, positions;
  for (const auto& [id, image] : setup.images) {
    if (!image.position) continue;
    stations.images.push_back(id);
    stations.positions_m.push_back(image.position->position_in_world);
    if (const auto position = looked_at(image, options)) {
      positions.images.push_back(id);
      positions.positions_m.push_back(*position);
    }
  }
  const auto count = static_cast<std::size_t>(std::max(0, options.neighbours));
  add_nearest(stations, count, pairs);
  add_nearest(positions, count, pairs);
  if (count > 0) add_by_sector(stations, pairs);
}

}  // namespace

bool all_pairs_wanted(const Block& setup, const PairOptions& options) {
  return options.pairs == PairChoice::kAll ||
         setup.images.size() < static_cast<std::size_t>(std::max(0, options.exhaustive_below));
}

std::vector<ImageIdPair> all_pairs(const Block& setup) {
  std::vector<ImageIdPair> pairs;
  for (auto a = setup.images.begin(); a != setup.images.end(); ++a)
    for (auto b = std::next(a); b != setup.images.end(); ++b) pairs.emplace_back(a->first, b->first);
  return pairs;
}

std::vector<ImageIdPair> candidate_pairs(const Block& setup, const PairOptions& options) {
  PairSet pairs;
  add_by_position(setup, options, pairs);
  add_sequence(setup, options, pairs);
  return pairs.sorted();
}

std::vector<ImageIdPair> joined(const std::vector<ImageIdPair>& a, const std::vector<ImageIdPair>& b) {
  std::vector<ImageIdPair> all;
  std::ranges::set_union(a, b, std::back_inserter(all));
  return all;
}

}  // namespace collinea
