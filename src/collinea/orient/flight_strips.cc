// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/flight_strips.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <span>
#include <tuple>

#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kBend_cos = 0.7071;  // 45 degrees: less is a strip flown in wind, more a cross strip
constexpr double kPause = 5;          // median intervals
constexpr double kWholeSecond_s = 1e-3;
constexpr std::size_t kShortest = 3;  // a shift and a drift of two images fit whatever they say

struct Exposure {
  ImageId id;
  Eigen::Vector3d centre;
  double time_s = 0;
};

// Seconds since some day, of "2024:05:17 10:31:08.25".
std::optional<double> seconds_of(const std::string& taken) {
  int year = 0, month = 0, day = 0, hour = 0, minute = 0;
  double second = 0;
  if (std::sscanf(taken.c_str(), "%d:%d:%d %d:%d:%lf", &year, &month, &day, &hour, &minute, &second) != 6)
    return std::nullopt;
  const int shifted = month <= 2 ? year - 1 : year;  // years that begin in March: leap days come last
  const long days =
      365L * shifted + shifted / 4 - shifted / 100 + shifted / 400 + (153 * ((month + 9) % 12) + 2) / 5 + day;
  return 86400.0 * static_cast<double>(days) + 3600.0 * hour + 60.0 * minute + second;
}

// In the order of their times; without these in that of names, with the numbers in that order as times.
std::vector<Exposure> exposures_of(const Block& block, bool* is_timed = nullptr) {
  std::vector<std::tuple<double, std::string, ImageId>> order;
  bool timed = true;
  for (const auto& [id, pose] : oriented_images(block)) {
    const Image& image = block.images.at(id);
    if (!image.position) continue;
    const auto time_s = seconds_of(image.taken);
    timed &= time_s.has_value();
    order.emplace_back(time_s.value_or(0), image.file, id);
  }
  if (is_timed) *is_timed = timed;
  if (!timed)
    for (auto& one : order) std::get<double>(one) = 0;  // the names tell, then
  std::sort(order.begin(), order.end());
  std::vector<Exposure> exposures;
  for (const auto& [time_s, file, id] : order)
    exposures.push_back({id, centre_of(pose_of(block, id)), timed ? time_s : static_cast<double>(exposures.size())});
  return exposures;
}

bool turns(const Eigen::Vector3d& before, const Eigen::Vector3d& after, double shortest_m) {
  const double a = before.head<2>().norm(), b = after.head<2>().norm();
  return a > shortest_m && b > shortest_m && before.head<2>().dot(after.head<2>()) < kBend_cos * a * b;
}

// The mean of the centres of all images of one time.
struct Instant {
  double time_s;
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
};

std::vector<Instant> instants_of(const FlightStrip& strip, const std::map<ImageId, const Exposure*>& exposure) {
  std::map<double, std::pair<Eigen::Vector3d, int>> sums;
  for (const auto& [id, time_s] : strip) {
    auto& [sum, count] = sums.try_emplace(time_s, Eigen::Vector3d::Zero(), 0).first->second;
    sum += exposure.at(id)->centre;
    ++count;
  }
  std::vector<Instant> instants;
  for (const auto& [time_s, sum] : sums) instants.push_back({time_s, sum.first / sum.second});
  return instants;
}

// Up to `count` instants around a time, where possible as many before as after.
std::span<const Instant> around(const std::vector<Instant>& way, double time_s, std::size_t count) {
  const auto at = static_cast<std::size_t>(std::ranges::find(way, time_s, &Instant::time_s) - way.begin());
  count = std::min(count, way.size());
  const std::size_t before = std::min(at, count / 2);
  return std::span(way).subspan(std::min(at - before, way.size() - count), count);
}

// By the parabola through three instants: strips begin and end with an acceleration.
std::optional<Eigen::Vector3d> by_parabola(const std::vector<Instant>& way, double time_s) {
  const std::span<const Instant> three = around(way, time_s, 3);
  if (three.size() < 2) return std::nullopt;
  const auto slope = [&](std::size_t i) -> Eigen::Vector3d {
    return (three[i + 1].centre - three[i].centre) / (three[i + 1].time_s - three[i].time_s);
  };
  if (three.size() < 3) return slope(0);
  const Eigen::Vector3d bend = (slope(1) - slope(0)) / (three[2].time_s - three[0].time_s);
  return slope(0) + bend * (2 * time_s - three[0].time_s - three[1].time_s);
}

// By the line through five, which bears times that are off by half a second.
std::optional<Eigen::Vector3d> by_line(const std::vector<Instant>& way, double time_s) {
  double middle_s = 0, spread_s2 = 0;
  const std::span<const Instant> five = around(way, time_s, 5);
  for (const Instant& one : five) middle_s += one.time_s / static_cast<double>(five.size());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Instant& one : five) {
    sum += (one.time_s - middle_s) * one.centre;
    spread_s2 += (one.time_s - middle_s) * (one.time_s - middle_s);
  }
  if (!(spread_s2 > 0)) return std::nullopt;
  return sum / spread_s2;
}

std::vector<FlightStrip> centred(const std::vector<std::vector<Exposure>>& parts) {
  std::vector<FlightStrip> strips;
  for (const std::vector<Exposure>& part : parts) {
    FlightStrip& strip = strips.emplace_back();
    double sum = 0;
    for (const Exposure& one : part) sum += one.time_s - part[0].time_s;
    const double middle = part[0].time_s + sum / static_cast<double>(part.size());
    for (const Exposure& one : part) strip[one.id] = one.time_s - middle;
  }
  return strips;
}

}  // namespace

std::vector<FlightStrip> flight_strips(const Block& block) {
  const std::vector<Exposure> all = exposures_of(block);
  if (all.empty()) return {};
  std::vector<double> steps_m, pauses_s;
  for (std::size_t i = 1; i < all.size(); ++i) {
    steps_m.push_back((all[i].centre - all[i - 1].centre).head<2>().norm());
    pauses_s.push_back(all[i].time_s - all[i - 1].time_s);
  }
  const double step_m = steps_m.empty() ? 0 : median(steps_m), pause_s = pauses_s.empty() ? 0 : median(pauses_s);
  std::vector<std::vector<Exposure>> parts{{all[0]}};
  for (std::size_t i = 1; i < all.size(); ++i) {
    const std::vector<Exposure>& part = parts.back();
    const Eigen::Vector3d step = all[i].centre - part.back().centre;
    const bool paused = pause_s > 0 && all[i].time_s - part.back().time_s > kPause * pause_s;
    const bool turned = part.size() > 1 && turns(part.back().centre - part[part.size() - 2].centre, step, step_m / 5);
    if (paused || turned)
      parts.push_back({all[i]});
    else
      parts.back().push_back(all[i]);
  }
  std::vector<std::vector<Exposure>> whole;
  for (auto& part : parts)
    if (whole.empty() || (part.size() >= kShortest && whole.back().size() >= kShortest))
      whole.push_back(std::move(part));
    else
      whole.back().insert(whole.back().end(), part.begin(), part.end());
  return centred(whole);
}

std::vector<FlightStrip> one_strip(const Block& block) {
  const std::vector<Exposure> all = exposures_of(block);
  return all.empty() ? std::vector<FlightStrip>{} : centred({all});
}

std::map<ImageId, Eigen::Vector3d> flight_velocities(const Block& block) {
  bool timed = false;
  const std::vector<Exposure> all = exposures_of(block, &timed);
  std::map<ImageId, Eigen::Vector3d> velocities;
  if (!timed) return velocities;
  const bool fine = std::ranges::any_of(
      all, [](const Exposure& one) { return std::abs(one.time_s - std::round(one.time_s)) > kWholeSecond_s; });
  std::map<ImageId, const Exposure*> exposure;
  for (const Exposure& one : all) exposure[one.id] = &one;
  for (const FlightStrip& strip : flight_strips(block)) {
    const std::vector<Instant> way = instants_of(strip, exposure);
    for (const auto& [id, time_s] : strip)
      if (const auto velocity = fine ? by_parabola(way, time_s) : by_line(way, time_s)) velocities[id] = *velocity;
  }
  return velocities;
}

}  // namespace collinea
