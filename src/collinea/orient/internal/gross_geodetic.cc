// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/gross_geodetic.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "collinea/adjust/geodetic_model.h"
#include "collinea/epipolar/intersect.h"

namespace collinea {
namespace {

constexpr double kBeyond = 5;  // sigmas: no chance explains more
constexpr double kLeastPart = 0.005, kMostPart = 0.1;
constexpr double kSpread = 10;  // sigmas of control over its extent: what a block is turned or scaled by at most
constexpr double kDegrees = 180 / std::numbers::pi;

// A measurement beside the block, directions from a zero at north.
struct Compared {
  std::size_t index;
  double difference;       // observed minus computed, [m] or [rad]
  double length_m;         // of what an angle moves: of a direction the level one
  double line_m, sigma_m;  // of the whole line, and of the two points across and along it
};

std::vector<Compared> compared(const Block& block) {
  std::vector<Compared> all;
  for (std::size_t i = 0; i < block.geodetic.size(); ++i) {
    const GeodeticObservation& one = block.geodetic[i];
    if (one.role != ControlRole::kControl || one.is_of_shape()) continue;
    const auto from = intersect(sight_lines(block, one.from)), to = intersect(sight_lines(block, one.to));
    if (!from || !to) continue;
    const Eigen::Vector3d line = to->point_in_world - from->point_in_world;
    const double length_m = one.kind == GeodeticKind::kDirection ? line.head<2>().norm() : line.norm();
    if (!(length_m > 0)) continue;
    const GeodeticModel model = geodetic_model(one, from->point_in_world, to->point_in_world, 0, {true});
    const double sigma_m = std::sqrt((from->covariance + to->covariance).trace());
    all.push_back({i, geodetic_residual(one, model), length_m, line.norm(), sigma_m});
  }
  return all;
}

double wrapped(double angle_rad) { return std::remainder(angle_rad, 2 * std::numbers::pi); }

// Zeros of set-ups: of one of their directions each, the one that the others are closest to.
void count_from_zero(const Block& block, std::vector<Compared>& all) {
  std::map<std::uint32_t, std::vector<Compared*>> setups;
  for (Compared& one : all)
    if (block.geodetic[one.index].kind == GeodeticKind::kDirection)
      setups[block.geodetic[one.index].setup].push_back(&one);
  for (auto& [setup, directions] : setups) {
    const auto cost = [&](const Compared* zero) {
      double sum = 0;
      for (const Compared* one : directions) sum += std::abs(wrapped(one->difference - zero->difference));
      return sum;
    };
    const double zero_rad = (*std::min_element(directions.begin(), directions.end(), [&](auto* a, auto* b) {
                              return cost(a) < cost(b);
                            }))->difference;
    for (Compared* one : directions) one->difference = wrapped(one->difference - zero_rad);
  }
}

}  // namespace

GrossGeodetic gross_geodetic(const Block& block, double part) {
  std::vector<Compared> all = compared(block);
  count_from_zero(block, all);
  GrossGeodetic found;
  for (const Compared& one : all) {
    const GeodeticObservation& measured = block.geodetic[one.index];
    const double metres = measured.is_angle() ? one.length_m : 1;
    const double off_m = std::abs(one.difference) * metres, sigma_m = std::hypot(one.sigma_m, measured.sigma * metres);
    if (off_m <= std::max(part * one.line_m, kBeyond * sigma_m)) continue;
    found.excluded.push_back(one.index);
    const Figure size = measured.is_angle() ? Figure{FigureName::kDifferenceAngle, std::abs(one.difference) * kDegrees}
                                            : Figure{FigureName::kOffset, off_m};
    found.findings.push_back(finding_of(FindingCode::kGrossErrorRejected, {Subject::geodetic(one.index)}, {size}));
  }
  return found;
}

double known_part(const Block& block, const std::set<ControlId>& control, double rotation_rad) {
  if (control.size() < 3) return std::max(kMostPart, kBeyond * rotation_rad);
  Eigen::Vector3d low = block.control.at(*control.begin()).position_in_world, high = low;
  double sigma_m = 0;
  for (const ControlId id : control) {
    const ControlPoint& point = block.control.at(id);
    low = low.cwiseMin(point.position_in_world);
    high = high.cwiseMax(point.position_in_world);
    for (const double its : point.sigma_m)
      if (std::isfinite(its)) sigma_m = std::max(sigma_m, its);
  }
  return std::max(kLeastPart, kSpread * sigma_m / (high - low).norm());
}

}  // namespace collinea
