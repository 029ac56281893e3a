// SPDX-License-Identifier: Apache-2.0
// Blocks joined with a network of total stations.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/adjust/geodetic_model.h"
#include "collinea/adjust/geodetic_positions.h"
#include "collinea/block/gnss_vector.h"
#include "collinea/block/subject_label.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::Marked;
using testing::marked;
using testing::tested;

const Run kRun;
constexpr double kSigma_m = 0.003, kSigma_rad = 20e-6;  // 3 mm, 1.3 mgon
constexpr double kOrientations[] = {0.7, -2.1, 3.1};
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Nine targets that images show, and three total stations that none shows, each of which measured directions, zenith
/// angles and distances to the targets and the others.
struct Network : Marked {
  static constexpr std::uint32_t kFirst = 20, kSecond = 21, kStations = 3;

  void observe(const GeodeticObservation& observation, double orientation_rad, double sigma, Random* random) {
    GeodeticObservation one = observation;
    one.sigma = sigma;
    one.value = geodetic_model(one, truth.at(one.from), truth.at(one.to), orientation_rad, {}).computed;
    if (random) one.value += sigma * random->normal();
    if (one.is_angle()) one.value = std::fmod(one.value + 4 * std::numbers::pi, 2 * std::numbers::pi);
    block.geodetic.push_back(one);
  }
};

Network network(std::uint64_t seed, double sigma_px, bool noise) {
  Network made{marked({.rows = 2, .columns = 4, .points = 80, .sigma_px = sigma_px, .seed = seed})};
  Random random(seed, 61);
  Random* errors = noise ? &random : nullptr;
  const Eigen::Vector3d stations[] = {{-12, -15, 1}, {55, 40, 4}, {60, -18, 2}};
  for (std::uint32_t s = 0; s < Network::kStations; ++s) {
    const ControlId id{Network::kFirst + s};
    made.truth[id] = stations[s];
    made.block.control[id] = {.name = "station" + std::to_string(s),
                              .role = ControlRole::kControl,
                              .position_in_map = Eigen::Vector3d::Zero(),
                              .position_in_world = Eigen::Vector3d::Zero(),
                              .sigma_m = Eigen::Vector3d::Constant(kInfinity)};
  }
  for (std::uint32_t s = 0; s < Network::kStations; ++s)
    for (const auto& [target, position] : made.truth) {
      const ControlId station{Network::kFirst + s};
      if (target == station) continue;
      GeodeticObservation one{.from = station, .to = target, .setup = s};
      one.instrument_height_m = 1.6;
      one.target_height_m = target.value >= Network::kFirst ? 1.5 : 0.1;
      const double orientation = kOrientations[s];
      one.kind = GeodeticKind::kDirection;
      made.observe(one, orientation, kSigma_rad, errors);
      one.kind = GeodeticKind::kZenithAngle;
      made.observe(one, orientation, kSigma_rad, errors);
      one.kind = GeodeticKind::kDistance;
      made.observe(one, orientation, kSigma_m, errors);
    }
  return made;
}

TEST(Network, PositionsOfStationsAreFoundFromWhatTheyMeasured) {
  const Network made = network(1, 0, false);
  std::vector<std::uint32_t> links(made.block.geodetic.size());
  for (std::uint32_t i = 0; i < links.size(); ++i) links[i] = i;
  std::map<ControlId, Eigen::Vector3d> positions = made.truth;
  positions.erase({Network::kFirst});
  positions.erase({Network::kSecond});
  positions.erase({Network::kSecond + 1});
  positions.erase({4});  // a target that no image shows
  bundle::find_positions_by_geodetic(made.block, links, positions);
  ASSERT_EQ(positions.size(), made.truth.size());
  for (const auto& [id, position] : positions) EXPECT_LT((position - made.truth.at(id)).norm(), 1e-9) << id.value;
  // Without distances a target is where the rays of both stations meet.
  Network angles = network(1, 0, false);
  std::erase_if(angles.block.geodetic, [](const GeodeticObservation& one) {
    return one.kind == GeodeticKind::kDistance && one.to.value == 4;
  });
  positions.erase({4});
  links.resize(angles.block.geodetic.size());
  bundle::find_positions_by_geodetic(angles.block, links, positions);
  EXPECT_LT((positions.at({4}) - made.truth.at({4})).norm(), 1e-9);
}

TEST(Network, AGnssVectorPlacesItsOtherEnd) {
  Network made = network(1, 0, false);
  made.block.geodetic.clear();
  const GnssVector vector{.vector = made.truth.at({5}) - made.truth.at({4}) + Eigen::Vector3d(0, 0, 0.5),
                          .covariance_m2 = Eigen::Vector3d(1, 2, 3).asDiagonal()};
  GeodeticObservation common{.from = {4}, .to = {5}, .setup = 0};
  common.instrument_height_m = 1.5;
  common.target_height_m = 2;
  const auto parts = observations_of(vector, common);
  made.block.geodetic.assign(parts->begin(), parts->end());
  for (const std::uint32_t lost : {4u, 5u}) {
    std::map<ControlId, Eigen::Vector3d> positions = made.truth;
    positions.erase({lost});
    bundle::find_positions_by_geodetic(made.block, {0, 1, 2}, positions);
    ASSERT_TRUE(positions.contains({lost}));
    EXPECT_LT((positions.at({lost}) - made.truth.at({lost})).norm(), 1e-9);
  }
}

TEST(Network, AzimuthsPlaceAStationFromOnePoint) {
  Network made = network(1, 0, false);
  made.block.geodetic.clear();
  const ControlId station{Network::kFirst};
  GeodeticObservation one{.from = station, .to = {4}};
  for (const GeodeticKind kind : {GeodeticKind::kAzimuth, GeodeticKind::kZenithAngle, GeodeticKind::kDistance}) {
    one.kind = kind;
    made.observe(one, 0, kSigma_rad, nullptr);
  }
  std::map<ControlId, Eigen::Vector3d> positions = made.truth;
  for (const ControlId lost : {station, ControlId{4}}) {
    positions.erase(lost);
    bundle::find_positions_by_geodetic(made.block, {0, 1, 2}, positions);
    ASSERT_TRUE(positions.contains(lost));
    EXPECT_LT((positions.at(lost) - made.truth.at(lost)).norm(), 1e-9);
  }
}

// The block's position and north are its own, its scale and level the network's.
TEST(Network, GivesScaleAndLevelToABlockWithout) {
  Network made = network(1, 0, false);
  const Eigen::Quaterniond rotation = rotation_by({0.02, -0.03, 0.8});
  for (auto [id, pose] : oriented_images(made.block)) {
    pose.rotation = pose.rotation * rotation.conjugate();
    pose.translation *= 1.02;
    set_pose(made.block, id, pose);
  }
  for (auto& [id, point] : made.block.points) point.position_in_world = 1.02 * (rotation * point.position_in_world);
  const auto adjusted = examine(made.block, {}, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->converged);
  EXPECT_EQ(adjusted->rank_defect, 4);  // position and north
  std::map<ControlId, Eigen::Vector3d> found;
  for (const ControlDifference& point : adjusted->control) found[point.point] = *point.position_in_world;
  ASSERT_EQ(found.size(), made.truth.size());
  for (const auto& [a, at_a] : made.truth)
    for (const auto& [b, at_b] : made.truth) {
      EXPECT_NEAR((found[a] - found[b]).norm(), (at_a - at_b).norm(), 1e-6);
      EXPECT_NEAR(found[a].z() - found[b].z(), at_a.z() - at_b.z(), 1e-6);
    }
  EXPECT_NEAR(adjusted->reliability->redundancy_sum, double(adjusted->redundancy), 1e-3);
}

// Stations with coordinates, which no image shows: through what they measured the block has its position.
TEST(Network, StationsWithCoordinatesPlaceTheBlock) {
  Network made = network(1, 0, false);
  for (std::uint32_t s = 0; s < Network::kStations; ++s) {
    ControlPoint& station = made.block.control.at({Network::kFirst + s});
    station.position_in_world = made.truth.at({Network::kFirst + s});
    station.sigma_m.setConstant(s == 0 ? 0 : 0.002);
  }
  Block start = testing::disturbed(made.block, 0.003, 0.2);
  const auto adjusted = examine(start, {}, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->rank_defect, 0);
  EXPECT_LT(testing::largest_centre_error(*adjusted, made.block), 1e-9);
  EXPECT_TRUE(!adjusted->undetermined);
}

// Stations, targets and orientations over their covariances, of 60 blocks whose positions come from the stations.
TEST(Network, ErrorsOfStationsAndPointsAreAsLargeAsTheirSigmas) {
  constexpr int kBlocks = 60;
  double stations = 0, targets = 0, orientations = 0, residuals = 0, freedom = 0;
  ExamineOptions options = tested(Calibration::kFocal);
  options.test.sigma0_known = true;
  for (int i = 0; i < kBlocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(i + 1);
    Network made = network(seed, 0.5, true);
    Random random(seed, 62);
    for (std::uint32_t s = 0; s < Network::kStations; ++s) {
      ControlPoint& station = made.block.control.at({Network::kFirst + s});
      station.position_in_world = made.truth.at({Network::kFirst + s}) + 0.005 * testing::normal3(random);
      station.sigma_m.setConstant(0.005);
    }
    AdjustScope scope;
    scope.first_cameras = made.block.cameras;
    scope.first_cameras.begin()->second.params[Camera::kF] += 50 * random.normal();
    const auto adjusted = examine(made.block, scope, options, kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    double of_targets = 0;
    for (const ControlDifference& point : adjusted->control) {
      const Eigen::Vector3d error = *point.position_in_world - made.truth.at(point.point);
      const double square = error.dot(point.covariance_m2->ldlt().solve(error)) / 3;
      (point.point.value >= Network::kFirst ? stations : of_targets) += square;
    }
    targets += of_targets / static_cast<double>(adjusted->control.size() - Network::kStations);
    for (const EstimatedUnknown& auxiliary : adjusted->auxiliaries)
      orientations += std::pow(
          std::remainder(auxiliary.value - kOrientations[auxiliary.owner], 2 * std::numbers::pi) / auxiliary.sigma, 2);
    for (const GeodeticKind kind : {GeodeticKind::kDistance, GeodeticKind::kDirection, GeodeticKind::kZenithAngle}) {
      const GroupSums& group = adjusted->reliability->groups[static_cast<std::size_t>(group_of(kind))];
      residuals += group.squares;
      freedom += group.redundancy;
    }
  }
  const double tolerance = 4 * std::sqrt(2.0 / kBlocks);
  EXPECT_NEAR(stations / (Network::kStations * kBlocks), 1, tolerance);
  EXPECT_NEAR(targets / kBlocks, 1, tolerance);
  EXPECT_NEAR(orientations / (Network::kStations * kBlocks), 1, tolerance);
  EXPECT_NEAR(residuals / freedom, 1, 4 * std::sqrt(2 / freedom));
}

TEST(Network, AGrossErrorIsFound) {
  for (const GeodeticKind kind : {GeodeticKind::kDirection, GeodeticKind::kZenithAngle, GeodeticKind::kDistance}) {
    Network made = network(3, 0.5, true);
    std::size_t wrong = made.block.geodetic.size();
    for (std::size_t i = 0; i < made.block.geodetic.size() && wrong == made.block.geodetic.size(); ++i)
      if (made.block.geodetic[i].kind == kind && made.block.geodetic[i].to.value == 5) wrong = i;
    made.block.geodetic[wrong].value += kind == GeodeticKind::kDistance ? 0.1 : 0.003;
    const auto adjusted = examine(made.block, {}, tested(Calibration::kFocal), kRun);
    ASSERT_TRUE(adjusted && adjusted->reliability && !adjusted->reliability->suspects.empty());
    EXPECT_EQ(adjusted->reliability->suspects[0].source, wrong);
    EXPECT_EQ(adjusted->reliability->suspects[0].group, group_of(kind));
  }
}

// Nothing fixes the position of this block and its stations, which no image shows: all of them are in the datum of the
// tie points. A station that an image shows, by a ray that weighs nothing, has the same covariance.
TEST(Network, StationsThatNoImageShowsAreInTheDatumOfTheOthers) {
  Network made = network(2, 0.5, true);
  const auto unseen = examine(made.block, {}, tested(), kRun);
  const ControlId station{Network::kFirst};
  const std::vector<OrientedImage> oriented = oriented_images(made.block);
  const auto looking = std::ranges::find_if(oriented, [&](const OrientedImage& one) {
    return project(made.block.camera_of(one.image), one.cam_from_world * made.truth.at(station)).has_value();
  });
  ASSERT_NE(looking, oriented.end());
  made.block.control_observations.push_back(
      {station, looking->image,
       *project(made.block.camera_of(looking->image), looking->cam_from_world * made.truth.at(station)), 1e5});
  const auto seen = examine(made.block, {}, tested(), kRun);
  ASSERT_TRUE(unseen && seen && !unseen->undetermined && !seen->undetermined);
  ASSERT_EQ(unseen->rank_defect, 4);
  const auto of_station = [&](const Examined& adjusted) {
    for (const ControlDifference& one : adjusted.control)
      if (one.point == station) return *one.covariance_m2;
    return Eigen::Matrix3d(Eigen::Matrix3d::Zero());
  };
  const Eigen::Matrix3d a = of_station(*unseen), b = of_station(*seen);
  ASSERT_GT(b.trace(), 0);
  EXPECT_LT((a - b).norm(), 1e-4 * b.norm());
}

// What a network leaves open is named, and the coordinates of a station that no image shows are known.
TEST(Network, WhatItLeavesOpenIsNamed) {
  Network made = network(1, 0.5, true);
  const auto says = [&](const char* what) {
    const auto adjusted = examine(made.block, {}, tested(), kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    const auto named = std::find_if(adjusted->weaknesses.begin(), adjusted->weaknesses.end(),
                                    [](const Finding& one) { return one.code == FindingCode::kDatumDefect; });
    ASSERT_NE(named, adjusted->weaknesses.end());
    EXPECT_NE(label_of(*named, made.block).find(what), std::string::npos) << label_of(*named, made.block);
    EXPECT_GT(named->figure(FigureName::kSteepness).value_or(0), 0.9);
  };
  says("datum_defect: rotation of block, position of block;");
  ControlPoint& station = made.block.control.at({Network::kFirst});
  station.position_in_world = made.truth.at({Network::kFirst});
  for (const double sigma : {0.002, 0.0}) {
    station.sigma_m.setConstant(sigma);
    says("datum_defect: rotation of block, control_point station0;");
  }
}

// Two stations with coordinates, exact or nearly, hold a block that begins metres off, askew and at a wrong scale: with
// options as they come, which stop at a twentieth of a standard deviation, all of the way is gone in a few steps. In a
// damped step the block only creeps towards what it hangs on by the network.
TEST(Network, ABlockThatHangsOnStationsGoesAllTheWay) {
  for (const double sigma_m : {0.0, 1e-5})
    for (const double rotation : {0.003, 0.05, 0.3}) {
      Network made = network(1, 0, false);
      for (const std::uint32_t id : {Network::kFirst, Network::kSecond}) {
        made.block.control.at({id}).position_in_world = made.truth.at({id});
        made.block.control.at({id}).sigma_m.setConstant(sigma_m);
      }
      Block start = testing::disturbed(made.block, 0.003, 0.2);
      const Eigen::Quaterniond rotated = rotation_by({rotation / 3, -rotation / 4, rotation});
      const auto moved = [&](const Eigen::Vector3d& position) {
        return Eigen::Vector3d(rotated * (1.02 * position) + Eigen::Vector3d(3, -2, 1));
      };
      for (auto [id, pose] : oriented_images(start)) {
        const Eigen::Vector3d centre = moved(centre_of(pose));
        pose.rotation = pose.rotation * rotated.conjugate();
        pose.translation = -(pose.rotation * centre);
        set_pose(start, id, pose);
      }
      for (auto& [id, point] : start.points) point.position_in_world = moved(point.position_in_world);
      const auto adjusted = adjust(
          start, {}, {.calibration = Calibration::kNone, .loss = Loss::kNone, .position_loss = Loss::kNone}, kRun);
      ASSERT_TRUE(adjusted) << adjusted.error().message;
      EXPECT_TRUE(adjusted->converged);
      EXPECT_EQ(adjusted->rank_defect, 0);
      EXPECT_LE(adjusted->iterations, 8);
      EXPECT_LT(testing::largest_centre_error(*adjusted, made.block), 1e-9) << sigma_m << " " << rotation;
    }
}

// One distance does not determine the position of a station; without its points being known a set-up is nowhere.
TEST(Network, WhatDoesNotDetermineAPointIsLeftOut) {
  Network made = network(1, 0, false);
  std::erase_if(made.block.geodetic, [](const GeodeticObservation& one) {
    return one.from.value == Network::kSecond && (one.kind != GeodeticKind::kDistance || one.to.value != 3);
  });
  std::erase_if(made.block.geodetic, [](const GeodeticObservation& one) { return one.to.value == Network::kSecond; });
  const auto adjusted = examine(made.block, {}, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->geodetic.size(), made.block.geodetic.size() - 1);
  for (const ControlDifference& point : adjusted->control) EXPECT_NE(point.point.value, Network::kSecond);
}

}  // namespace
}  // namespace collinea
