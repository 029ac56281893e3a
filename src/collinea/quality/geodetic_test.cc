// SPDX-License-Identifier: Apache-2.0
// Measurements on the ground: distances, height differences and what a total station measures.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "collinea/adjust/geodetic_model.h"
#include "collinea/block/gnss_vector.h"
#include "collinea/block/world_frame.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/snooping.h"
#include "collinea/quality/variance_components.h"

namespace collinea {
namespace {

using testing::Marked;
using testing::marked;
using testing::normal3;
using testing::test_block;
using testing::tested;

const Run kRun;

void scale(Block& block, double factor) {
  for (auto [id, pose] : oriented_images(block)) {
    pose.translation *= factor;
    set_pose(block, id, pose);
  }
  for (auto& [id, point] : block.points) point.position_in_world *= factor;
}

TEST(GeodeticModel, DerivativesAreThoseOfDifferences) {
  Random random(3);
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d from = 300 * normal3(random), to = 300 * normal3(random);
    for (const GeodeticKind kind : {GeodeticKind::kDistance, GeodeticKind::kHeightDifference, GeodeticKind::kDirection,
                                    GeodeticKind::kZenithAngle, GeodeticKind::kAzimuth, GeodeticKind::kGnssVector})
      for (const bool curved : {false, true}) {
        const GeodeticObservation one{.kind = kind,
                                      .instrument_height_m = 1.6,
                                      .target_height_m = 0.3,
                                      .along = {0.48, -0.6, 0.64},
                                      .is_local = i % 2 == 0};
        const Earth earth{.is_round = curved,
                          .pole = {0, 0.6, 0.8},
                          .deflection_rad = curved ? Eigen::Vector2d(1e-4, -2e-4) : Eigen::Vector2d::Zero()};
        const GeodeticModel model = geodetic_model(one, from, to, 0.4, earth);
        constexpr double kStep_m = 1e-3;
        for (int c = 0; c < 3; ++c) {
          const Eigen::Vector3d step = kStep_m * Eigen::Vector3d::Unit(c);
          const auto slope = [&](const Eigen::Vector3d& df, const Eigen::Vector3d& dt) {
            const double change = geodetic_model(one, from + df, to + dt, 0.4, earth).computed -
                                  geodetic_model(one, from - df, to - dt, 0.4, earth).computed;
            return (one.is_angle() ? std::remainder(change, 2 * std::numbers::pi) : change) / (2 * kStep_m);
          };
          // What the derivatives leave out of a round Earth: 1e-6 times what they are where lines are not steep; of a
          // vector the length over the Earth's radius.
          const double tolerance = !curved ? 1e-8 : kind == GeodeticKind::kGnssVector ? 4e-4 : 2e-6;
          EXPECT_NEAR(slope(step, {0, 0, 0}), model.by_from[c], tolerance) << static_cast<int>(kind);
          EXPECT_NEAR(slope({0, 0, 0}, step), model.by_to[c], tolerance) << static_cast<int>(kind);
        }
        const double rotated = geodetic_model(one, from, to, 0.4 + 1e-3, earth).computed - model.computed;
        EXPECT_NEAR(rotated, 1e-3 * model.by_auxiliary[0], 1e-12);
      }
  }
}

// At 48 degrees of latitude the meridians of points a kilometre apart converge by 36 seconds of arc: the azimuth there
// and that back differ by it. At the pole's own axis it would be a turn.
TEST(GeodeticModel, MeridiansConverge) {
  const double latitude = 48 * std::numbers::pi / 180;
  const Earth earth{.is_round = true, .pole = {0, std::cos(latitude), std::sin(latitude)}};
  const GeodeticObservation one{.kind = GeodeticKind::kAzimuth};
  const Eigen::Vector3d here(0, 0, 0), there(1000, 0, 0);
  EXPECT_NEAR(geodetic_model(one, here, there, 0, earth).computed, std::numbers::pi / 2, 1e-12);
  const double convergence = 1000 / 6371000.0 * std::tan(latitude);
  EXPECT_NEAR(geodetic_model(one, there, here, 0, earth).computed, -std::numbers::pi / 2 + convergence, 1e-8);
  EXPECT_NEAR(geodetic_model(one, there, here, 0, {}).computed, -std::numbers::pi / 2, 1e-12);
}

// Ten seconds of arc to the north: a level line to the north falls by 48 mm below the ellipsoid in a kilometre, a
// target there is seen nearer to the zenith. Laplace: the astronomical azimuth is larger by eta tan(latitude).
TEST(GeodeticModel, TheDeflectionTiltsWhatIsLevelled) {
  constexpr double kTilt_rad = 10 * std::numbers::pi / 180 / 3600;
  const double latitude = 48 * std::numbers::pi / 180;
  const Earth plain{.is_round = true, .pole = {0, std::cos(latitude), std::sin(latitude)}};
  Earth north = plain, east = plain;
  north.deflection_rad = {kTilt_rad, 0};
  east.deflection_rad = {0, kTilt_rad};
  const Eigen::Vector3d here(0, 0, 0), there(0, 1000, 0);
  const auto change = [&](GeodeticKind kind, const Earth& earth) {
    const GeodeticObservation one{.kind = kind};
    return geodetic_model(one, here, there, 0, earth).computed - geodetic_model(one, here, there, 0, plain).computed;
  };
  EXPECT_NEAR(change(GeodeticKind::kHeightDifference, north), 0.04848, 1e-5);
  EXPECT_NEAR(change(GeodeticKind::kZenithAngle, north), -kTilt_rad, 1e-9);
  EXPECT_NEAR(change(GeodeticKind::kHeightDifference, east), 0, 1e-9);
  EXPECT_NEAR(change(GeodeticKind::kAzimuth, east), kTilt_rad * std::tan(latitude), 1e-8);
  EXPECT_NEAR(change(GeodeticKind::kDistance, east), 0, 1e-12);
}

// Levelled heights and zenith angles fit control once the plumb line is where it was.
TEST(Geodetic, TheDeflectionOfTheBlockIsTakenFromItsGeoreference) {
  Marked made = marked({.rows = 2, .columns = 3, .points = 60});
  const double latitude = 48 * std::numbers::pi / 180;
  const Earth earth{
      .is_round = true, .pole = {0, std::cos(latitude), std::sin(latitude)}, .deflection_rad = {2e-3, -1e-3}};
  for (auto& [id, point] : made.block.control) point.sigma_m.setConstant(0.001);
  for (std::uint32_t to = 1; to < 6; ++to)
    for (const GeodeticKind kind : {GeodeticKind::kHeightDifference, GeodeticKind::kZenithAngle}) {
      GeodeticObservation one{.kind = kind, .from = {0}, .to = {to}, .sigma = 1e-3, .role = ControlRole::kCheck};
      one.value = geodetic_model(one, made.truth.at({0}), made.truth.at({to}), 0, earth).computed;
      made.block.geodetic.push_back(one);
    }
  const auto largest = [&] {
    const auto adjusted = examine(made.block, {}, tested(), kRun);
    EXPECT_TRUE(adjusted && adjusted->geodetic.size() == 10);
    double difference = 0;
    for (const GeodeticDifference& one : adjusted->geodetic)
      difference = std::max(difference, std::abs(one.difference));
    return difference;
  };
  made.block.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  EXPECT_GT(largest(), 0.01);
  made.block.georeference->deflection_north_rad = 2e-3;
  made.block.georeference->deflection_east_rad = -1e-3;
  EXPECT_LT(largest(), 1e-6);
}

TEST(GeodeticModel, TheEarthIsRound) {
  const GeodeticObservation levelled{.kind = GeodeticKind::kHeightDifference};
  EXPECT_NEAR(geodetic_model(levelled, {0, 0, 0}, {1000, 0, 0}, 0, {true}).computed, 1e6 / (2 * 6371000.0), 1e-6);
  EXPECT_EQ(geodetic_model(levelled, {0, 0, 0}, {1000, 0, 0}, 0, {}).computed, 0);
}

TEST(Geodetic, OneDistanceGivesAFreeBlockItsScale) {
  Marked made = marked({.rows = 2, .columns = 3, .points = 80});
  made.measure(GeodeticKind::kDistance, 0, 3, 0.001);
  scale(made.block, 1.3);
  const auto adjusted = examine(made.block, {}, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->rank_defect, 6);
  EXPECT_EQ(adjusted->datum, (DatumSources{.geodetic = true, .parts = 1}));
  EXPECT_GT(adjusted->rank_defect, 0);
  std::map<ControlId, Eigen::Vector3d> found;
  for (const ControlDifference& point : adjusted->control) found[point.point] = *point.position_in_world;
  for (const auto& [a, at_a] : made.truth)
    for (const auto& [b, at_b] : made.truth)
      if (found.contains(a) && found.contains(b)) {
        EXPECT_NEAR((found[a] - found[b]).norm(), (at_a - at_b).norm(), 1e-7);
      }
  ASSERT_EQ(adjusted->geodetic.size(), 1u);
  EXPECT_NEAR(adjusted->geodetic[0].difference, 0, 1e-9);
  EXPECT_NEAR(adjusted->geodetic[0].sigma, 0.001, 1e-9);  // nothing else knows the scale
  EXPECT_NEAR(adjusted->reliability->redundancy_sum, double(adjusted->redundancy), 1e-5);
}

// The same adjustment with a point eliminated or kept among the reduced unknowns: a distance that weighs nothing.
TEST(Geodetic, PointsThatAreJoinedAreAdjustedLikeOthers) {
  Block block =
      test_block({.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 6});
  const auto without = examine(block, {}, tested(Calibration::kFocalRadial), kRun);
  block.geodetic.push_back({.from = {0}, .to = {4}, .value = 10, .sigma = 1e6});
  const auto with = examine(block, {}, tested(Calibration::kFocalRadial), kRun);
  ASSERT_TRUE(without && with && without->reliability && with->reliability);
  EXPECT_EQ(with->unknown_count, without->unknown_count);
  EXPECT_EQ(with->redundancy, without->redundancy + 1);
  EXPECT_NEAR(with->final_cost, without->final_cost, 1e-6);
  for (const auto& [id, covariance] : without->pose_covariance)
    EXPECT_LT((with->pose_covariance.at(id) - covariance).norm(), 1e-6 * covariance.norm());
  for (std::size_t i = 0; i < without->control.size(); ++i) {
    const ControlDifference &a = without->control[i], &b = with->control[i];
    EXPECT_EQ(a.used, b.used);
    EXPECT_LT((a.difference_m - b.difference_m).norm(), 1e-6);
    EXPECT_LT((*a.covariance_m2 - *b.covariance_m2).norm(), 1e-6 * a.covariance_m2->norm());
    EXPECT_LT((a.difference_sigma_m - b.difference_sigma_m).norm(), 5e-3 * a.difference_sigma_m.norm());
  }
  const auto& a = without->reliability->others;
  const auto& b = with->reliability->others;
  ASSERT_EQ(a.size() + 1, b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i].redundancy, b[i].redundancy, 1e-6);
  EXPECT_NEAR(b.back().redundancy, 1, 1e-6);
  EXPECT_NEAR(with->reliability->redundancy_sum, double(with->redundancy), 1e-4);
}

// A check point that is measured to takes part without its coordinates, which stay independent of it.
TEST(Geodetic, CoordinatesOfCheckPointsStayOut) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 60, .position_sigma_m = 0.05, .control = 6});
  const double length = (block.control.at({0}).position_in_world - block.control.at({2}).position_in_world).norm();
  block.geodetic.push_back({.from = {0}, .to = {2}, .value = length, .sigma = 0.005});
  ASSERT_EQ(block.control.at({2}).role, ControlRole::kCheck);
  const auto first = examine(block, {}, tested(), kRun);
  block.control.at({2}).position_in_world += Eigen::Vector3d(1, 1, 1);
  const auto second = examine(block, {}, tested(), kRun);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->final_cost, second->final_cost);
  EXPECT_FALSE(second->control[2].used);
  EXPECT_NEAR((second->control[2].difference_m - first->control[2].difference_m).x(), -1, 1e-12);
  EXPECT_GT(second->control[2].difference_sigma_m.minCoeff(), 0.01);  // that of the survey and more
}

// Scale is seen by distances alone: its error over its sigma is a standard normal variable, of 100 blocks.
TEST(Geodetic, ErrorsOfDistancesAreAsLargeAsTheirSigmas) {
  double squares = 0, residuals = 0;
  constexpr int kBlocks = 100;
  for (int i = 0; i < kBlocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(i + 1);
    Marked made = marked({.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .seed = seed});
    Random random(seed, 9);
    made.measure(GeodeticKind::kDistance, 0, 3, 0.01, &random);
    made.measure(GeodeticKind::kDistance, 1, 4, 0.01, &random);
    made.measure(GeodeticKind::kDistance, 2, 5, 1, &random);
    made.block.geodetic.back().role = ControlRole::kCheck;
    ExamineOptions options = tested(Calibration::kFocal);
    options.test.sigma0_known = true;
    const auto adjusted = examine(made.block, {}, options, kRun);
    ASSERT_TRUE(adjusted && adjusted->geodetic.size() == 3) << i;
    EXPECT_FALSE(adjusted->geodetic[2].used);
    const GeodeticDifference& check = adjusted->geodetic[2];
    squares +=
        std::pow(check.adjusted - (made.truth.at({2}) - made.truth.at({5})).norm(), 2) / (check.sigma * check.sigma);
    for (int k = 0; k < 2; ++k)
      residuals += std::pow(adjusted->geodetic[k].difference / adjusted->geodetic[k].difference_sigma, 2) / 2;
  }
  const double tolerance = 4 * std::sqrt(2.0 / kBlocks);
  EXPECT_NEAR(squares / kBlocks, 1, tolerance);
  EXPECT_NEAR(residuals / kBlocks, 1, tolerance);
}

// North is seen by azimuths alone, on a round Earth: its error over its sigma is a standard normal variable, of 100
// blocks.
TEST(Geodetic, ErrorsOfAzimuthsAreAsLargeAsTheirSigmas) {
  double squares = 0, residuals = 0;
  constexpr int kBlocks = 100;
  constexpr double kSigma_rad = 1e-3, kLatitude = 48 * std::numbers::pi / 180;
  const Earth earth{.is_round = true, .pole = {0, std::cos(kLatitude), std::sin(kLatitude)}};
  for (int i = 0; i < kBlocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(i + 1);
    Marked made = marked({.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .seed = seed});
    made.block.georeference = Georeference{"EPSG:32633", 48, 15, 300};
    Random random(seed, 9);
    const auto measure = [&](GeodeticKind kind, std::uint32_t from, std::uint32_t to, double sigma) {
      GeodeticObservation one{.kind = kind, .from = {from}, .to = {to}, .sigma = sigma};
      one.value = geodetic_model(one, made.truth.at(one.from), made.truth.at(one.to), 0, earth).computed +
                  sigma * random.normal();
      made.block.geodetic.push_back(one);
    };
    for (const std::uint32_t to : {3u, 4u}) measure(GeodeticKind::kAzimuth, to - 3, to, kSigma_rad);
    measure(GeodeticKind::kAzimuth, 2, 5, 1);
    made.block.geodetic.back().role = ControlRole::kCheck;
    measure(GeodeticKind::kDistance, 0, 3, 0.01);
    for (const std::uint32_t to : {3u, 4u, 6u}) measure(GeodeticKind::kHeightDifference, to - 3, to, 0.005);
    ExamineOptions options = tested(Calibration::kFocal);
    options.test.sigma0_known = true;
    const auto adjusted = examine(made.block, {}, options, kRun);
    ASSERT_TRUE(adjusted && adjusted->geodetic.size() == 7) << i;
    EXPECT_EQ(adjusted->rank_defect, 3);
    const GeodeticDifference& check = adjusted->geodetic[2];
    const double truth =
        geodetic_model(made.block.geodetic[2], made.truth.at({2}), made.truth.at({5}), 0, earth).computed;
    squares += std::pow(std::remainder(check.adjusted - truth, 2 * std::numbers::pi) / check.sigma, 2);
    for (int k = 0; k < 2; ++k)
      residuals += std::pow(adjusted->geodetic[k].difference / adjusted->geodetic[k].difference_sigma, 2) / 2;
  }
  const double tolerance = 4 * std::sqrt(2.0 / kBlocks);
  EXPECT_NEAR(squares / kBlocks, 1, tolerance);
  EXPECT_NEAR(residuals / kBlocks, 1, tolerance);
}

// East, north and up of a receiver three kilometres from the origin are those of the ellipsoid there.
TEST(GeodeticModel, LocalAxesOfAVectorAreThoseOfItsFirstPoint) {
  const Georeference position{"EPSG:32633", 48.2, 15.63, 300};
  const auto frame = world_frame(position);
  ASSERT_TRUE(frame);
  const double latitude = position.origin_latitude_deg * std::numbers::pi / 180;
  const Earth earth{.is_round = true, .pole = {0, std::cos(latitude), std::sin(latitude)}};
  const Eigen::Vector3d from(2000, -2300, 40), to(2600, -1400, 15);
  const Eigen::Vector3d there = frame->geographic_from_local(from);
  const auto at = LocalFrame::create(position.crs, there.x(), there.y(), there.z());
  ASSERT_TRUE(at);
  const Eigen::Vector3d local = at->local_from_geographic(frame->geographic_from_local(to));
  for (int axis = 0; axis < 3; ++axis) {
    const GeodeticObservation one{
        .kind = GeodeticKind::kGnssVector, .along = Eigen::Vector3d::Unit(axis), .is_local = true};
    EXPECT_NEAR(geodetic_model(one, from, to, 0, earth).computed, local[axis], 0.002) << axis;  // of 1.1 km
  }
}

// Three vectors place a block but for its position. What they are off, in sigmas, and the errors of a fourth that is
// only compared are standard normal, of 100 blocks.
TEST(Geodetic, ErrorsOfGnssVectorsAreAsLargeAsTheirSigmas) {
  double squares = 0, residuals = 0, redundancy = 0;
  constexpr int kBlocks = 100;
  const Eigen::Matrix3d root = (Eigen::Matrix3d() << 5e-3, 0, 0, 2e-3, 4e-3, 0, -3e-3, 1e-3, 9e-3).finished();
  for (int i = 0; i < kBlocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(i + 1);
    Marked made = marked({.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .seed = seed});
    Random random(seed, 9);
    std::uint32_t number = 0;
    const auto measure = [&](std::uint32_t from, std::uint32_t to, ControlRole role) {
      GnssVector vector{.covariance_m2 = root * root.transpose()};
      vector.vector = made.truth.at({to}) - made.truth.at({from}) + root * normal3(random);
      const GeodeticObservation common{.from = {from}, .to = {to}, .role = role, .setup = number++};
      const auto parts = observations_of(vector, common);
      made.block.geodetic.insert(made.block.geodetic.end(), parts->begin(), parts->end());
    };
    measure(0, 3, ControlRole::kControl);
    measure(1, 4, ControlRole::kControl);
    measure(2, 6, ControlRole::kControl);
    measure(5, 7, ControlRole::kCheck);
    ExamineOptions options = tested(Calibration::kFocal);
    options.test.sigma0_known = true;
    const auto adjusted = examine(made.block, {}, options, kRun);
    ASSERT_TRUE(adjusted && adjusted->geodetic.size() == 12) << i;
    EXPECT_EQ(adjusted->rank_defect, 3);
    for (std::size_t k = 9; k < 12; ++k) {
      const GeodeticObservation& check = made.block.geodetic[k];
      const double truth = check.along.dot(made.truth.at(check.to) - made.truth.at(check.from));
      squares += std::pow((adjusted->geodetic[k].adjusted - truth) / adjusted->geodetic[k].sigma, 2) / 3;
    }
    const GroupSums& group = adjusted->reliability->groups[std::size_t(ObservationGroup::kGnssVector)];
    residuals += group.squares;
    redundancy += group.redundancy;
  }
  EXPECT_NEAR(squares / kBlocks, 1, 4 * std::sqrt(2.0 / kBlocks));
  EXPECT_NEAR(residuals / redundancy, 1, 4 * std::sqrt(2 / redundancy));
}

// One wrong component is found, and all of the vector goes: its parts are one measurement.
TEST(Geodetic, AWrongGnssVectorIsRejectedAsAWhole) {
  Marked made = marked({.sigma_px = 0.5});
  Random random(4);
  for (std::uint32_t i = 1; i < 7; ++i) {
    GnssVector vector{.covariance_m2 = Eigen::Vector3d(2e-5, 3e-5, 9e-5).asDiagonal()};
    vector.vector = made.truth.at({i}) - made.truth.at({0}) + 0.005 * normal3(random);
    if (i == 3) vector.vector.x() += 0.2;
    const auto parts = observations_of(vector, {.from = {0}, .to = {i}, .setup = i});
    made.block.geodetic.insert(made.block.geodetic.end(), parts->begin(), parts->end());
  }
  const auto snooped = snoop(made.block, {}, tested(Calibration::kFocalRadial), 100, kRun);
  ASSERT_TRUE(snooped) << snooped.error().message;
  for (const GeodeticDifference& one : snooped->adjusted.geodetic)
    EXPECT_EQ(one.used, made.block.geodetic[one.observation].setup != 3) << one.observation;
}

TEST(Geodetic, AGrossErrorInADistanceIsFound) {
  Marked made = marked({.sigma_px = 0.5});
  Random random(4);
  for (std::uint32_t i = 1; i < 7; ++i) made.measure(GeodeticKind::kDistance, 0, i, 0.005, &random);
  made.block.geodetic[3].value += 0.1;
  const auto adjusted = examine(made.block, {}, tested(Calibration::kFocalRadial), kRun);
  ASSERT_TRUE(adjusted && adjusted->reliability);
  ASSERT_FALSE(adjusted->reliability->suspects.empty());
  const TestedObservation& worst = adjusted->reliability->suspects[0];
  EXPECT_EQ(worst.group, ObservationGroup::kDistance);
  EXPECT_EQ(worst.source, 3u);
  EXPECT_NEAR(worst.gross_error, 0.1, 0.03);
}

TEST(Geodetic, HeightDifferencesLevelABlock) {
  Marked made = marked({.rows = 2, .columns = 3, .points = 80});
  made.measure(GeodeticKind::kDistance, 0, 3, 0.001);
  made.measure(GeodeticKind::kHeightDifference, 0, 3, 0.001);
  made.measure(GeodeticKind::kHeightDifference, 1, 4, 0.001);
  made.measure(GeodeticKind::kHeightDifference, 2, 6, 0.001);
  const Eigen::Quaterniond rotation = rotation_by({0.03, -0.02, 0.5});
  for (auto [id, pose] : oriented_images(made.block)) {
    pose.rotation = pose.rotation * rotation.conjugate();
    set_pose(made.block, id, pose);
  }
  for (auto& [id, point] : made.block.points) point.position_in_world = rotation * point.position_in_world;
  const auto adjusted = examine(made.block, {}, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->rank_defect, 4);  // position and north
  std::map<ControlId, double> height;
  for (const ControlDifference& point : adjusted->control) height[point.point] = point.position_in_world->z();
  for (const auto& [id, at] : made.truth)
    EXPECT_NEAR(height.at(id) - height.at({0}), at.z() - made.truth.at({0}).z(), 1e-6);
}

TEST(Geodetic, VarianceComponentsFindTheSigmaOfDistances) {
  Marked made = marked({.points = 120, .sigma_px = 0.5, .position_sigma_m = 0.02});
  Random random(8);
  for (std::uint32_t i = 0; i < 9; ++i)
    for (std::uint32_t k = 0; k < i; ++k) made.measure(GeodeticKind::kDistance, k, i, 0.03, &random);
  for (GeodeticObservation& measured : made.block.geodetic) measured.sigma /= 3;
  const auto found = estimate_variance_components(made.block, {}, tested(), kRun);
  ASSERT_TRUE(found) << found.error().message;
  const auto group = static_cast<std::size_t>(ObservationGroup::kDistance);
  EXPECT_NEAR(found->factors[group], 3, 4 * found->sigma[group]);
  EXPECT_GT(found->sigma[group], 0);
}

TEST(Geodetic, ThreadsDoNotChangeABit) {
  Marked made = marked({.rows = 6, .columns = 8, .points = 900, .sigma_px = 0.5, .position_sigma_m = 0.05});
  for (std::uint32_t i = 1; i < 7; ++i) made.measure(GeodeticKind::kDistance, 0, i, 0.005);
  collinea::Run threads;
  threads.threads = 3;
  const auto one = examine(made.block, {}, tested(Calibration::kFocalRadial), kRun),
             three = examine(made.block, {}, tested(Calibration::kFocalRadial), threads);
  ASSERT_TRUE(one && three);
  EXPECT_EQ(one->final_cost, three->final_cost);
  EXPECT_EQ(one->geodetic[2].sigma, three->geodetic[2].sigma);
}

TEST(Geodetic, WhatCannotBeIsRefusedOrLeftOut) {
  Marked made = marked({.rows = 2, .columns = 3, .points = 60, .position_sigma_m = 0.05});
  made.measure(GeodeticKind::kDistance, 0, 3, 0.001);
  Block bad = made.block;
  bad.geodetic[0].sigma = 0;
  EXPECT_EQ(examine(bad, {}, tested(), kRun).error().code, Errc::kBadInput);
  bad = made.block;
  bad.geodetic[0].to = bad.geodetic[0].from;
  EXPECT_EQ(examine(bad, {}, tested(), kRun).error().code, Errc::kBadInput);
  bad = made.block;  // a point that no image shows
  std::erase_if(bad.control_observations, [](const ControlObservation& seen) { return seen.point.value == 3; });
  const auto adjusted = examine(bad, {}, tested(), kRun);
  ASSERT_TRUE(adjusted);
  EXPECT_TRUE(adjusted->geodetic.empty());
  const auto unused = examine(made.block, {.use_geodetic = false}, tested(), kRun);
  ASSERT_TRUE(unused);
  EXPECT_TRUE(unused->geodetic.empty());
}

}  // namespace
}  // namespace collinea
