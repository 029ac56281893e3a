// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/geodetic_positions.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <optional>
#include <utility>

namespace collinea::bundle {
namespace {

/// What one set-up measured to one point. The Earth counts as flat: these are approximations.
struct Sight {
  ControlId target;
  double direction_rad = 0;
  std::optional<double> zenith_rad, distance_m;
  double instrument_height_m = 0, target_height_m = 0;

  [[nodiscard]] bool polar() const { return zenith_rad && distance_m; }
  /// From the mark of the set-up to that of the target, if the circle's zero points to `orientation_rad`.
  [[nodiscard]] Eigen::Vector3d line(double orientation_rad) const {
    const double across = *distance_m * std::sin(*zenith_rad), azimuth = direction_rad + orientation_rad;
    return {across * std::sin(azimuth), across * std::cos(azimuth),
            instrument_height_m + *distance_m * std::cos(*zenith_rad) - target_height_m};
  }
};

struct SetUp {
  ControlId station;
  bool is_oriented = false;  ///< zero of its circle is north: azimuths
  std::vector<Sight> sights;
};

std::vector<SetUp> setups_of(const Block& block, const std::vector<std::uint32_t>& links) {
  std::map<std::pair<bool, std::uint32_t>, SetUp> setups;  // by the numbers of set-ups, azimuths by those of points
  for (const std::uint32_t link : links) {
    const GeodeticObservation& one = block.geodetic[link];
    const bool is_azimuth = one.kind == GeodeticKind::kAzimuth;
    if (one.kind != GeodeticKind::kDirection && !is_azimuth) continue;
    SetUp& setup = setups[{is_azimuth, is_azimuth ? one.from.value : one.setup}];
    setup.station = one.from;
    setup.is_oriented = is_azimuth;
    setup.sights.push_back({one.to, one.value, {}, {}, one.instrument_height_m, one.target_height_m});
  }
  std::vector<SetUp> all;
  for (auto& [number, setup] : setups) {
    for (Sight& sight : setup.sights)
      for (const std::uint32_t link : links) {
        const GeodeticObservation& one = block.geodetic[link];
        const bool there = one.from == setup.station && one.to == sight.target;
        const bool back = one.to == setup.station && one.from == sight.target;
        if (one.kind == GeodeticKind::kZenithAngle && there) sight.zenith_rad = one.value;
        if (one.kind == GeodeticKind::kDistance && (there || (back && !sight.distance_m))) sight.distance_m = one.value;
      }
    all.push_back(std::move(setup));
  }
  return all;
}

/// A GNSS vector from mark to mark.
struct Vector {
  ControlId from, to;
  Eigen::Vector3d line;
};

std::vector<Vector> vectors_of(const Block& block, const std::vector<std::uint32_t>& links) {
  std::map<std::uint32_t, std::vector<const GeodeticObservation*>> parts;
  for (const std::uint32_t link : links)
    if (const GeodeticObservation& one = block.geodetic[link]; one.kind == GeodeticKind::kGnssVector)
      parts[one.setup].push_back(&one);
  std::vector<Vector> vectors;
  for (const auto& [number, its] : parts) {
    if (its.size() != 3) continue;
    Vector vector{its[0]->from, its[0]->to,
                  (its[0]->instrument_height_m - its[0]->target_height_m) * Eigen::Vector3d::UnitZ()};
    for (const GeodeticObservation* one : its) vector.line += one->value * one->along;
    vectors.push_back(vector);
  }
  return vectors;
}

class PositionFinder {
 public:
  PositionFinder(const Block& block, const std::vector<std::uint32_t>& links,
                 std::map<ControlId, Eigen::Vector3d>& positions)
      : setups_(setups_of(block, links)), vectors_(vectors_of(block, links)), positions_(positions) {}

  void find() {
    for (bool found = true; found;) {
      found = false;
      rays_.clear();
      for (const SetUp& setup : setups_) {
        if (!positions_.contains(setup.station)) found |= locate_station(setup);
        if (positions_.contains(setup.station)) found |= sight_from(setup);
      }
      for (const Vector& vector : vectors_) found |= go_along(vector);
      for (const auto& [target, rays] : rays_)
        if (!positions_.contains(target)) found |= intersect(target, rays);
    }
  }

 private:
  struct Ray {
    Eigen::Vector3d from, along;
  };

  bool go_along(const Vector& vector) {
    const bool is_from = positions_.contains(vector.from);
    if (is_from == positions_.contains(vector.to)) return false;
    if (is_from)
      positions_[vector.to] = Eigen::Vector3d(positions_[vector.from] + vector.line);
    else
      positions_[vector.from] = Eigen::Vector3d(positions_[vector.to] - vector.line);
    return true;
  }

  [[nodiscard]] const Eigen::Vector3d* position_of(ControlId point) const {
    const auto its = positions_.find(point);
    return its == positions_.end() ? nullptr : &its->second;
  }

  // One point is enough where north is known.
  bool locate_oriented(const SetUp& setup) {
    for (const Sight& sight : setup.sights)
      if (const Eigen::Vector3d* position = position_of(sight.target); position && sight.polar()) {
        const Eigen::Vector3d station = *position - sight.line(0);
        positions_[setup.station] = station;
        return true;
      }
    return false;
  }

  // Its orientation and position: a rotation about the plumb line and a shift.
  bool locate_station(const SetUp& setup) {
    if (setup.is_oriented) return locate_oriented(setup);
    std::vector<std::pair<Eigen::Vector3d, Eigen::Vector3d>> pairs;  // as seen from there, in the world
    Eigen::Vector3d middle = Eigen::Vector3d::Zero(), middle_there = middle;
    for (const Sight& sight : setup.sights)
      if (const Eigen::Vector3d* position = position_of(sight.target); position && sight.polar())
        pairs.emplace_back(sight.line(0), *position);
    if (pairs.size() < 2) return false;
    for (const auto& [line, position] : pairs) {
      middle_there += line / static_cast<double>(pairs.size());
      middle += position / static_cast<double>(pairs.size());
    }
    double sine = 0, cosine = 0;
    for (const auto& [line, position] : pairs) {
      const Eigen::Vector3d a = line - middle_there, b = position - middle;
      sine += a.x() * b.y() - a.y() * b.x();
      cosine += a.x() * b.x() + a.y() * b.y();
    }
    if (sine == 0 && cosine == 0) return false;
    const Eigen::AngleAxisd rotation(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ());
    positions_[setup.station] = middle - rotation * middle_there;
    return true;
  }

  // Where its circle's zero points to, by the middle of what the points there are say.
  [[nodiscard]] std::optional<double> orientation_of(const SetUp& setup) const {
    if (setup.is_oriented) return 0;
    const Eigen::Vector3d station = *position_of(setup.station);
    double sine = 0, cosine = 0;
    for (const Sight& sight : setup.sights)
      if (const Eigen::Vector3d* position = position_of(sight.target)) {
        const Eigen::Vector3d line = *position - station;
        if (line.head<2>().norm() == 0) continue;
        const double orientation = std::atan2(line.x(), line.y()) - sight.direction_rad;
        sine += std::sin(orientation), cosine += std::cos(orientation);
      }
    if (sine == 0 && cosine == 0) return std::nullopt;
    return std::atan2(sine, cosine);
  }

  bool sight_from(const SetUp& setup) {
    const auto orientation = orientation_of(setup);
    if (!orientation) return false;
    bool found = false;
    const Eigen::Vector3d station = positions_.at(setup.station);
    for (const Sight& sight : setup.sights) {
      if (positions_.contains(sight.target)) continue;
      if (sight.polar()) {
        positions_[sight.target] = station + sight.line(*orientation);
        found = true;
      } else if (sight.zenith_rad) {
        const double azimuth = sight.direction_rad + *orientation, level = std::sin(*sight.zenith_rad);
        rays_[sight.target].push_back(
            {station + (sight.instrument_height_m - sight.target_height_m) * Eigen::Vector3d::UnitZ(),
             {level * std::sin(azimuth), level * std::cos(azimuth), std::cos(*sight.zenith_rad)}});
      }
    }
    return found;
  }

  bool intersect(ControlId target, const std::vector<Ray>& rays) {
    Eigen::Matrix3d normals = Eigen::Matrix3d::Zero();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (const Ray& ray : rays) {
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - ray.along * ray.along.transpose();
      normals += across;
      right += across * ray.from;
    }
    constexpr double kLeastAngle2 = 1e-4;  // of two rays: half a degree
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(normals);
    if (!(eigen.eigenvalues()[0] > kLeastAngle2)) return false;
    positions_[target] = normals.ldlt().solve(right);
    return true;
  }

  std::vector<SetUp> setups_;
  std::vector<Vector> vectors_;
  std::map<ControlId, std::vector<Ray>> rays_;
  std::map<ControlId, Eigen::Vector3d>& positions_;
};

}  // namespace

void find_positions_by_geodetic(const Block& block, const std::vector<std::uint32_t>& geodetic,
                                std::map<ControlId, Eigen::Vector3d>& positions) {
  PositionFinder(block, geodetic, positions).find();
}

}  // namespace collinea::bundle
