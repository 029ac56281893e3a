// SPDX-License-Identifier: Apache-2.0
// Laws of every kind of observation. One that is added to the list needs an item in observed_every_way(), or the first
// test fails.
#include "collinea/adjust/observation_kinds.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <stdexcept>
#include <typeinfo>
#include <vector>

#include "collinea/adjust/gather.h"
#include "collinea/adjust/internal/step.h"
#include "collinea/adjust/survey_block.h"

namespace collinea {
namespace {

using testing::normal3;
using testing::Surveyed;

const Run kRun;

// A block with observations of every kind, and with all unknowns that these may have of their own.
Surveyed observed_every_way() {
  Surveyed made = testing::surveyed_every_way(1);
  Random random(4);
  PositionTrack track;
  track.shift_sigma_m = track.drift_sigma_m = Eigen::Vector3d::Constant(0.5);
  for (auto& [id, image] : made.block.images) {
    const Rigid3& pose = pose_of(made.block, id);
    image.position = PositionPrior{centre_of(pose) + 0.05 * normal3(random), Eigen::Vector3d::Constant(0.05)};
    made.scope.velocity_m_s[id] = 10 * normal3(random);
    made.scope.attitudes[id] = {(pose.rotation * rotation_by(1e-4 * normal3(random))).normalized(),
                                Eigen::Vector3d::Constant(1e-3)};
    made.scope.verticals[id] = {(pose.rotation * Eigen::Vector3d::UnitZ() + 1e-3 * normal3(random)).normalized(), 0.01};
    track.time[id] = random.normal();
    const CameraId camera = image.camera;
    made.scope.lever_arms[camera] = {Eigen::Vector3d(0.1, 0.2, 0.3), Eigen::Vector3d::Constant(0.1)};
    made.scope.boresight_sigma_rad[camera] = Eigen::Vector3d::Constant(0.01);
    made.scope.time_offset_sigma_s[camera] = 0.1;
  }
  for (auto& [id, camera] : made.block.cameras) {
    camera.additional = AdditionalSet::kFilm;
    camera.prior.film = FilmPrior{.sigma_px = 0.5, .correlation_px = 300};
  }
  made.scope.position_tracks = {track};
  made.scope.use_positions = true;
  return made;
}

TEST(ObservationKinds, AStepChangesResidualsAsTheirDerivativesPredict) {
  const Surveyed made = observed_every_way();
  const auto gathered = bundle::gather(made.block, made.scope, {.calibration = Calibration::kBrown});
  ASSERT_TRUE(gathered) << gathered.error().message;
  const bundle::Problem& problem = gathered->problem;
  const bundle::State& state = gathered->start;
  Random random(5);
  bundle::Step step;
  step.reduced.resize(static_cast<std::size_t>(6 * problem.poses + problem.global_count));
  for (double& value : step.reduced) value = 1e-6 * random.normal();
  const bundle::State next = moved(problem, state, 0, step, kRun);
  std::set<GeodeticKind> measured;
  for (const bundle::GeodeticLink& link : problem.geodetic) measured.insert(link.observation.kind);
  EXPECT_EQ(measured.size(), kGeodeticKinds);
  bundle::for_each_kind([&]<class Kind>() {
    if constexpr (!Kind::kIsOfPoint) {  // its derivatives are those of the point alone
      int items = 0;
      Kind::for_each(problem, [&](const auto& item) {
        ++items;
        const auto before = Kind::whitened(problem, state, item), after = Kind::whitened(problem, next, item);
        const auto predicted = Kind::predicted(problem, state, next, step.reduced, item);
        EXPECT_LT((after - predicted).norm(), 2e-3 * (after - before).norm() + 1e-9) << typeid(Kind).name();
      });
      EXPECT_GT(items, 0) << typeid(Kind).name();
    }
  });
}

// Each item of a kind counts with what it has: together with the image points these are the observations.
TEST(ObservationKinds, RowsAreAsManyAsTheObservations) {
  const Surveyed made = observed_every_way();
  const auto gathered = bundle::gather(made.block, made.scope, {.calibration = Calibration::kBrown});
  ASSERT_TRUE(gathered) << gathered.error().message;
  const bundle::Problem& problem = gathered->problem;
  long rows = 2 * static_cast<long>(problem.rays.size() + problem.verticals.size());
  for (const bundle::ControlCoordinates& control : problem.control)
    for (const double inverse_sigma : control.inverse_sigma) rows += inverse_sigma > 0;
  bundle::for_each_kind([&]<class Kind>() {
    if constexpr (requires(const typename Kind::Item& item) { Kind::row(problem, gathered->start, item, 0); })
      bundle::for_each_row<Kind>(problem, gathered->start, [&](const auto&, int, const auto&) { ++rows; });
  });
  EXPECT_EQ(rows, problem.observation_count);
}

TEST(ObservationGroups, AreThoseOfTheirSourcesAndAxes) {
  for (const ObservationGroupTraits& its : kObservationGroupTraits) {
    const std::vector<ObservationGroup> groups = groups_of(its.source);
    EXPECT_EQ(std::count(groups.begin(), groups.end(), its.group), 1) << int(its.group);
    if (its.source == ObservationSource::kGeodetic) continue;
    for (int axis = its.first_axis; axis < its.first_axis + its.axes; ++axis)
      EXPECT_EQ(group_of(its.source, axis), its.group) << int(its.group);
  }
  EXPECT_THROW(static_cast<void>(group_of(ObservationSource::kTieImagePoint, 2)), std::logic_error);
  EXPECT_THROW(static_cast<void>(group_of(ObservationSource::kGeodetic, 0)), std::logic_error);
}

}  // namespace
}  // namespace collinea
