// SPDX-License-Identifier: Apache-2.0
#pragma once

// A block whose points were surveyed in every way there is, for the tests of this module and its benchmark.

#include <vector>

#include "collinea/adjust/test_block.h"

namespace collinea::testing {

struct Surveyed {
  Block block;
  AdjustScope scope;
};

/// What a tape between neighbours, and a total station, every other instrument and a level in the first of these points
/// measure, with errors; `exact` has the true positions.
inline void measure_geodetic(const Block& exact, Block& block, const std::vector<ControlId>& ids, double length_m,
                             double angle_rad, Random& random) {
  const auto position = [&](ControlId id) { return exact.control.at(id).position_in_world; };
  const auto add = [&](GeodeticKind kind, ControlId from, ControlId to) {
    GeodeticObservation one{.kind = kind, .from = from, .to = to};
    one.sigma = one.is_angle() ? angle_rad : length_m;
    if (kind == GeodeticKind::kDirection) one.setup = 1;
    if (kind == GeodeticKind::kAtHeight) one.setup = 2;
    if (kind == GeodeticKind::kGnssVector) {
      one.setup = static_cast<std::uint32_t>(block.geodetic.size());
      one.along = Eigen::Vector3d(0.48, 0.6, 0.64);
      one.is_local = one.setup % 2 == 0;
    }
    const double computed = kind == GeodeticKind::kAtHeight
                                ? position(from).z() - 3
                                : geodetic_model(one, position(from), position(to), 0.3, {}).computed;
    one.value = computed + one.sigma * random.normal();
    block.geodetic.push_back(one);
  };
  for (std::size_t i = 1; i < ids.size(); ++i)
    for (std::size_t k = 0; k < kGeodeticKinds; ++k)
      if (const auto kind = static_cast<GeodeticKind>(k); !GeodeticObservation{.kind = kind}.is_of_shape())
        add(kind, ids[kind == GeodeticKind::kDistance ? i - 1 : 0], ids[i]);
  for (const ControlId id : ids) add(GeodeticKind::kAtHeight, id, id);
}

/// Points 0 to 5 surveyed with coordinates and instruments; of the others, without coordinates, five are at one height,
/// six on a plane and five on a line. The sigmas are true but for those of image points: their errors are `px` times
/// those.
inline Surveyed surveyed_every_way(std::uint64_t seed, double px = 1) {
  constexpr std::uint32_t kHeights = 6, kPlane = 11, kLine = 17, kAll = 22;
  constexpr double kSigma_m = 0.003, kShape_m = 0.01, kSigma_rad = 2e-4, kSigma_px = 0.5;
  const auto move = [&](std::vector<Eigen::Vector3d>& positions) {
    const Eigen::Vector3d normal = Eigen::Vector3d(0.4, 0.2, 1).normalized(), along(0.8, 0.6, 0.05);
    for (std::uint32_t i = kHeights; i < kPlane; ++i) positions[i].z() = 2;
    for (std::uint32_t i = kPlane; i < kLine; ++i)
      positions[i] -= normal * normal.dot(positions[i] - Eigen::Vector3d(20, 15, 0));
    for (std::uint32_t i = kLine; i < kAll; ++i)
      positions[i] = Eigen::Vector3d(5, 5, 1) + along * (positions[i].x() * 0.8);
  };
  const TestBlockOptions options{.rows = 2, .columns = 4, .points = 60, .sigma_px = kSigma_px * px, .seed = seed};
  Surveyed made{marked(options, kAll, move).block, {}};
  for (auto& seen : made.block.observations) seen.sigma_px = kSigma_px;
  for (auto& seen : made.block.control_observations) seen.sigma_px = kSigma_px;
  Random random(seed, 12);
  std::vector<ControlId> ids;
  for (std::uint32_t i = 0; i < kHeights; ++i) ids.push_back({i});
  measure_geodetic(made.block, made.block, ids, kSigma_m, kSigma_rad, random);
  const auto shape = [&](GeodeticKind kind, std::uint32_t from, std::uint32_t to, int axes) {
    for (std::uint32_t i = from; i < to; ++i)
      for (int axis = 0; axis < axes; ++axis)
        made.block.geodetic.push_back({.kind = kind,
                                       .from = {i},
                                       .to = {i},
                                       .value = kShape_m * random.normal(),
                                       .sigma = kShape_m,
                                       .setup = 0,
                                       .axis = axis});
  };
  shape(GeodeticKind::kAtHeight, kHeights, kPlane, 1);
  shape(GeodeticKind::kOnPlane, kPlane, kLine, 1);
  shape(GeodeticKind::kOnLine, kLine, kAll, 2);
  for (auto& [id, control] : made.block.control) {
    control.role = ControlRole::kControl;
    if (id.value < kHeights) control.sigma_m.setConstant(0.01);
    control.position_in_world += 0.01 * normal3(random);
  }
  made.scope.use_positions = false;
  return made;
}

}  // namespace collinea::testing
