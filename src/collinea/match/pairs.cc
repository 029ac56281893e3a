// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/pairs.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

namespace collinea {
namespace {

constexpr int kSectors = 8;
constexpr int kPerSector = 2;
constexpr double kSectorReach = 3;  // times the usual distance of neighbours

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

struct Station {
  ImageId image;
  Eigen::Vector3d position_m;
  double footprint_m = 0;  // the shorter side on the ground; 0 when not known
};

std::vector<Station> stations_of(const Block& setup, const PairOptions& options) {
  std::vector<Station> stations;
  for (const auto& [id, image] : setup.images) {
    if (!image.position) continue;
    Station& station = stations.emplace_back(Station{id, image.position->position_in_world});
    const auto camera = setup.cameras.find(image.camera);
    if (options.height_above_ground_m && camera != setup.cameras.end() && camera->second.focal_px() > 0)
      station.footprint_m = *options.height_above_ground_m *
                            std::min(camera->second.width_px, camera->second.height_px) / camera->second.focal_px();
  }
  return stations;
}

struct Neighbour {
  double distance_m;
  std::size_t station;
  friend auto operator<=>(const Neighbour&, const Neighbour&) = default;
};

// All others, the nearest `count` of them sorted in front.
std::vector<Neighbour> neighbours_of(std::size_t i, const std::vector<Station>& stations, std::size_t count) {
  std::vector<Neighbour> others;
  others.reserve(stations.size());
  for (std::size_t j = 0; j < stations.size(); ++j)
    if (j != i) others.push_back({(stations[j].position_m - stations[i].position_m).norm(), j});
  std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(std::min(count, others.size())));
  return others;
}

// The median over the stations of the distance to the last of its nearest neighbours.
double usual_reach_m(const std::vector<Station>& stations, std::size_t count) {
  std::vector<double> distances_m;
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const std::vector<Neighbour> others = neighbours_of(i, stations, count);
    if (!others.empty()) distances_m.push_back(others[std::min(count, others.size()) - 1].distance_m);
  }
  if (distances_m.empty()) return 0;
  const auto middle = distances_m.begin() + static_cast<std::ptrdiff_t>(distances_m.size() / 2);
  std::ranges::nth_element(distances_m, middle);
  return *middle;
}

void add_by_sector(std::size_t i, const std::vector<Station>& stations, double reach_m, PairSet& pairs) {
  std::array<std::vector<Neighbour>, kSectors> sectors;
  for (std::size_t j = 0; j < stations.size(); ++j) {
    const Eigen::Vector3d step_m = stations[j].position_m - stations[i].position_m;
    const double distance_m = std::hypot(step_m.x(), step_m.y());
    if (j == i || distance_m > reach_m) continue;
    const double turns = std::atan2(step_m.y(), step_m.x()) / (2 * std::numbers::pi) + 1;
    sectors[static_cast<std::size_t>(std::lround(turns * kSectors)) % kSectors].push_back({distance_m, j});
  }
  for (std::vector<Neighbour>& sector : sectors) {
    const std::size_t count = std::min<std::size_t>(kPerSector, sector.size());
    std::ranges::partial_sort(sector, sector.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t k = 0; k < count; ++k) pairs.add(stations[i].image, stations[sector[k].station].image);
  }
}

void add_by_position(const Block& setup, const PairOptions& options, PairSet& pairs) {
  const std::vector<Station> stations = stations_of(setup, options);
  const auto count = static_cast<std::size_t>(std::max(1, options.neighbours));
  const double reach_m = kSectorReach * usual_reach_m(stations, count);
  for (std::size_t i = 0; i < stations.size(); ++i) {
    const std::vector<Neighbour> others = neighbours_of(i, stations, 4 * count);
    for (std::size_t k = 0; k < std::min(4 * count, others.size()); ++k) {
      const Station& other = stations[others[k].station];
      const double largest_m = std::min(stations[i].footprint_m, other.footprint_m) * (1 - options.min_overlap);
      if (k < count || others[k].distance_m < largest_m) pairs.add(stations[i].image, other.image);
    }
    add_by_sector(i, stations, reach_m, pairs);
  }
}

bool is_small(const Block& setup, const PairOptions& options) {
  return setup.images.size() < static_cast<std::size_t>(std::max(0, options.exhaustive_below));
}

}  // namespace

std::vector<ImageIdPair> select_pairs(const Block& setup, const PairOptions& options) {
  PairSet pairs;
  if (is_small(setup, options)) {
    for (const auto& [a, one] : setup.images)
      for (const auto& [b, other] : setup.images) pairs.add(a, b);
    return pairs.sorted();
  }
  add_by_position(setup, options, pairs);
  add_sequence(setup, options, pairs);
  return pairs.sorted();
}

std::vector<ImageId> images_to_preselect(const Block& setup, const PairOptions& options) {
  std::vector<ImageId> images;
  if (is_small(setup, options)) return images;
  for (const auto& [id, image] : setup.images)
    if (!image.position) images.push_back(id);
  return images;
}

std::vector<ImageIdPair> joined(std::span<const ImageIdPair> a, std::span<const ImageIdPair> b) {
  std::vector<ImageIdPair> all;
  std::ranges::set_union(a, b, std::back_inserter(all));
  return all;
}

}  // namespace collinea
