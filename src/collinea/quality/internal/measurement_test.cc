// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/measurement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>
#include <vector>

#include "collinea/adjust/survey_block.h"

namespace collinea {
namespace {

// Every group of observations occurs.
Measurements measured_every_way() {
  testing::Surveyed made = testing::surveyed_every_way(1);
  for (const auto& [id, pose] : oriented_images(made.block)) {
    made.block.images.at(id).position = PositionPrior{centre_of(pose), Eigen::Vector3d(0.1, 0.2, 0.3)};
    made.scope.attitudes[id] = {pose.rotation, Eigen::Vector3d(1e-3, 2e-3, 3e-3)};
  }
  return {made.block, made.scope};
}

// One measurement of each group.
std::vector<MeasurementIndex> one_of_each(const Measurements& all) {
  std::vector<MeasurementIndex> found;
  for (const ObservationGroupTraits& traits : kObservationGroupTraits) switch (traits.source) {
      case ObservationSource::kTieImagePoint:
      case ObservationSource::kControlImagePoint:
        found.push_back({traits.group, 7});
        break;
      case ObservationSource::kControlCoordinates:
        found.push_back({traits.group, all.block.control.begin()->first.value});
        break;
      case ObservationSource::kPosition:
      case ObservationSource::kAttitude:
        found.push_back({traits.group, all.block.images.begin()->first.value});
        break;
      case ObservationSource::kGeodetic:
        for (std::uint32_t i = 0; i < all.block.geodetic.size(); ++i)
          if (group_of(all.block.geodetic[i].kind) == traits.group) {
            found.push_back({traits.group, i});
            break;
          }
    }
  return found;
}

// All that says whether and where something was measured; image points of control in any order.
auto values_of(const Measurements& all) {
  std::vector<std::tuple<int, std::uint32_t, std::uint32_t, double, double, double>> values;
  for (const Observation& seen : all.block.observations)
    values.emplace_back(0, seen.point.value, seen.image.value, seen.pixel.x(), seen.pixel.y(), seen.sigma_px);
  for (const ControlObservation& seen : all.block.control_observations)
    values.emplace_back(1, seen.point.value, seen.image.value, seen.pixel.x(), seen.pixel.y(), seen.sigma_px);
  std::sort(values.begin(), values.end());
  const auto add = [&](int kind, std::uint32_t id, const Eigen::Vector3d& sigma) {
    values.emplace_back(kind, id, 0, sigma.x(), sigma.y(), sigma.z());
  };
  for (const auto& [id, point] : all.block.control) add(2, id.value, point.sigma_m);
  for (const auto& [id, image] : all.block.images) add(3, id.value, image.position->sigma_m);
  for (const auto& [id, attitude] : all.scope.attitudes) add(4, id.value, attitude.sigma_rad);
  for (const GeodeticObservation& one : all.block.geodetic)
    values.emplace_back(5, one.from.value, one.to.value, one.value, one.sigma, static_cast<double>(one.role));
  return values;
}

TEST(Measurement, OfEveryGroupGoesByItselfAndComesBackAsItWas) {
  const Measurements all = measured_every_way();
  const std::vector<MeasurementIndex> indices = one_of_each(all);
  ASSERT_EQ(indices.size(), kObservationGroups);
  const auto before = values_of(all);
  for (const MeasurementIndex& index : indices) {
    const int group = static_cast<int>(index.group);
    const Measurement measurement = measurement_at(index, all.block);
    EXPECT_EQ(measurement.group, index.group) << group;
    const Measurements left = without(all, std::vector{index});
    EXPECT_NE(values_of(left), before) << group;
    const Measurements again = with(left, measurement, given_at(index, all));
    EXPECT_EQ(values_of(again), before) << group;
    EXPECT_TRUE(std::ranges::is_sorted(again.block.observations, {}, [](const Observation& seen) {
      return std::pair(seen.point, seen.image);
    })) << group;
  }
}

TEST(Measurement, AllGroupsGoTogetherAndComeBackInAnyOrder) {
  const Measurements all = measured_every_way();
  std::vector<MeasurementIndex> indices = one_of_each(all);
  Measurements left = without(all, indices);
  EXPECT_EQ(left.block.observations.size() + 1, all.block.observations.size());
  EXPECT_EQ(left.block.control_observations.size() + 1, all.block.control_observations.size());
  EXPECT_TRUE(left.block.control.begin()->second.sigma_m.array().isInf().all());
  EXPECT_TRUE(left.block.images.begin()->second.position->sigma_m.array().isInf().all());
  EXPECT_TRUE(left.scope.attitudes.begin()->second.sigma_rad.array().isInf().all());
  EXPECT_EQ(std::ranges::count(left.block.geodetic, ControlRole::kCheck, &GeodeticObservation::role),
            static_cast<long>(kGeodeticKinds));
  std::ranges::reverse(indices);
  for (const MeasurementIndex& index : indices)
    left = with(std::move(left), measurement_at(index, all.block), given_at(index, all));
  EXPECT_EQ(values_of(left), values_of(all));
}

TEST(Measurement, PlanGoesWithoutHeightAndHeightWithoutPlan) {
  const Measurements all = measured_every_way();
  const std::uint32_t control = all.block.control.begin()->first.value;
  const auto sigma = [&](ObservationGroup group) {
    return without(all, std::vector{MeasurementIndex{group, control}}).block.control.begin()->second.sigma_m;
  };
  const Eigen::Vector3d plan = sigma(ObservationGroup::kControlPlan), height = sigma(ObservationGroup::kControlHeight);
  EXPECT_TRUE(std::isinf(plan.x()) && std::isinf(plan.y()) && std::isfinite(plan.z()));
  EXPECT_TRUE(std::isfinite(height.x()) && std::isfinite(height.y()) && std::isinf(height.z()));
}

TEST(Measurement, IsNamedAlikeWhateverItsIndex) {
  const Measurements all = measured_every_way();
  for (const ObservationGroup group : {ObservationGroup::kTieImages, ObservationGroup::kControlImages}) {
    const Measurement last = measurement_at({group, 9}, all.block);
    const Measurements left = without(all, std::vector<MeasurementIndex>{{group, 2}, {group, 5}});
    EXPECT_EQ(measurement_at({group, 7}, left.block), last);
    EXPECT_NE(measurement_at({group, 9}, left.block), last);
  }
}

TEST(Measurement, OfAnImagePointHasNoCoordinatesOfControl) {
  const Measurements all = measured_every_way();
  for (const MeasurementIndex& index : one_of_each(all)) {
    const std::set<ControlId> points = control_points_of(measurement_at(index, all.block), all.block);
    const ObservationSource source = traits_of(index.group).source;
    const bool has = source == ObservationSource::kControlCoordinates || source == ObservationSource::kGeodetic;
    EXPECT_EQ(!points.empty(), has) << static_cast<int>(index.group);
  }
}

// An adjustment that says of everything that it lies where the block has it: what is wrong is wrong by what was added.
TEST(Measurement, IsOffByWhatWasAddedToIt) {
  Measurements all = measured_every_way();
  const ControlId control = all.block.control.begin()->first;
  const ImageId image = all.block.images.begin()->first;
  Adjusted adjusted;
  adjusted.control.push_back({.point = control, .position_in_world = all.block.control.at(control).position_in_world});
  adjusted.attitudes.push_back({image, Eigen::Vector3d(0, 0, -0.25)});
  adjusted.geodetic.push_back({.observation = 3, .difference = -0.5});
  const Eigen::Vector3d off(1, -2, 3);
  all.block.control.at(control).position_in_world += off;
  all.block.images.at(image).position->position_in_world += off;
  const auto misclosure_at = [&](ObservationGroup group, std::uint32_t source) {
    const MeasurementIndex index{group, source};
    return misclosure(measurement_at(index, all.block), given_at(index, all), all, adjusted);
  };
  EXPECT_LT((*misclosure_at(ObservationGroup::kControlPlan, control.value) - off).norm(), 1e-12);
  EXPECT_LT((*misclosure_at(ObservationGroup::kPositionPlan, image.value) - off).norm(), 1e-12);
  EXPECT_EQ(misclosure_at(ObservationGroup::kAttitudeHeading, image.value)->z(), 0.25);
  EXPECT_EQ(misclosure_at(group_of(all.block.geodetic[3].kind), 3)->x(), 0.5);
  EXPECT_FALSE(misclosure_at(group_of(all.block.geodetic[4].kind), 4));
  EXPECT_FALSE(misclosure_at(ObservationGroup::kControlHeight, std::next(all.block.control.begin())->first.value));
  all.scope.lever_arms[CameraId{1}] = {};
  EXPECT_FALSE(misclosure_at(ObservationGroup::kPositionPlan, image.value));
}

}  // namespace
}  // namespace collinea
