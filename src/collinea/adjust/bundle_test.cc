// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/bundle.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numeric>

#include "collinea/adjust/point_normals.h"
#include "collinea/adjust/test_block.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {
namespace {

using testing::disturbed;
using testing::largest_centre_error;
using testing::measured_anew;
using testing::normal3;
using testing::plain;
using testing::test_block;

const Run kRun;

// Without noise the only error is rounding: 1e-16 of 60 m, times the condition of the block.
TEST(Adjust, ExactTruthComesBackFromADisturbedStart) {
  const Block truth = test_block({.position_sigma_m = 0, .control = 9});
  const auto adjusted = adjust(disturbed(truth, 0.02, 1.0), {}, plain(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->converged);
  EXPECT_EQ(adjusted->rank_defect, 0);
  EXPECT_EQ(adjusted->datum, (DatumSources{.control = true, .parts = 1}));
  EXPECT_LT(largest_centre_error(*adjusted, truth), 1e-8 * 60);
  for (const auto& [id, position] : adjusted->points)
    EXPECT_LT((position - truth.points.at(id).position_in_world).norm(), 1e-8 * 60);
  EXPECT_GT(adjusted->points.size(), 190u);
  int checks = 0;
  for (const ControlDifference& control : adjusted->control) {
    EXPECT_LT(control.difference_m.norm(), 1e-6);
    checks += !control.used;
  }
  EXPECT_EQ(checks, 3);
  for (const Eigen::Vector2d& residual : adjusted->control_residuals_px) EXPECT_LT(residual.norm(), 1e-5);
}

TEST(Adjust, SelfCalibrationFindsTheCamera) {
  Block truth = test_block({.points = 400, .control = 12, .tilt_rad = 0.35});
  Camera& camera = truth.cameras.begin()->second;
  camera.params[Camera::kB1] = 0;
  Block start = disturbed(truth, 0.005, 0.3);
  Camera first = ideal_camera(1540, 2000, 1500);
  first.prior.sigma_f_px = 1e6;
  start.cameras.begin()->second = first;
  for (auto& observation : start.observations) observation.sigma_px = 1e-4;  // the pseudo-observations shall not count
  for (auto& observation : start.control_observations) observation.sigma_px = 1e-4;
  for (auto& [id, point] : start.control) point.sigma_m.setConstant(1e-6);
  const auto adjusted = adjust(start, {}, plain(Calibration::kBrown), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  const Camera& found = adjusted->cameras.at(CameraId{1});
  for (int k = 0; k < Camera::kParams; ++k)
    EXPECT_NEAR(found.params[k], camera.params[k], 1e-4 * std::max(1e-3, std::abs(camera.params[k])))
        << Camera::kParamNames[k];
  EXPECT_LT(largest_centre_error(*adjusted, truth), 1e-3);
}

// sigma0^2 r is chi-squared with r degrees of freedom: sigma0 is 1 +- 1/sqrt(2 r). Four of those.
TEST(Adjust, Sigma0IsOneWhenTheSigmasAreTrue) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Block block = test_block({.sigma_px = 0.7, .position_sigma_m = 0.1, .control = 6, .seed = seed});
    const auto adjusted = adjust(block, {}, plain(Calibration::kFocalRadial), kRun);
    ASSERT_TRUE(adjusted);
    EXPECT_NEAR(adjusted->sigma0, 1, 4 / std::sqrt(2.0 * double(adjusted->redundancy)));
    EXPECT_EQ(adjusted->datum, (DatumSources{.control = true, .positions = true, .parts = 1}));
  }
}

TEST(Adjust, RobustLossKeepsOutliersFromDoingHarm) {
  const Block truth = test_block({.sigma_px = 0.5, .control = 9, .seed = 3});
  Block block = truth;
  Random random(8);
  for (auto& observation : block.observations)
    if (random.uniform() < 0.05)
      observation.pixel += 60 * Eigen::Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
  const auto clean = adjust(truth, {}, plain(), kRun);
  AdjustOptions options = plain();
  const auto spoiled = adjust(block, {}, options, kRun);
  options.loss = Loss::kCauchy;
  const auto robust = adjust(block, {}, options, kRun);
  ASSERT_TRUE(clean && spoiled && robust);
  const double best = largest_centre_error(*clean, truth);
  EXPECT_LT(largest_centre_error(*robust, truth), 2 * best + 0.01);
  EXPECT_GT(largest_centre_error(*spoiled, truth), 3 * largest_centre_error(*robust, truth));
}

// Mussio D.8 (4.3.7): 33 images (30 models in 3 strips) and 66 points have 6 * 33 + 3 * 66 = 396 = 12 * 33 unknowns
// (E39: 12 to 15 an image, not 13 to 16); 2 observations a ray.
TEST(Adjust, UnknownsOfMussioD8) {
  const Block block = test_block({.rows = 3, .columns = 11, .points = 66});
  const auto adjusted = adjust(block, {}, plain(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->unknown_count, 396);
  EXPECT_EQ(adjusted->observation_count, 2 * long(block.observations.size()));
  EXPECT_EQ(adjusted->redundancy, adjusted->observation_count - 396 + 7);
}

TEST(Adjust, TwoUnconnectedPartsHaveFourteenDefects) {
  Block block = test_block({.rows = 1, .columns = 3, .points = 60});
  const Block second = test_block({.rows = 1, .columns = 3, .points = 60, .seed = 5});
  for (const auto& [id, image] : second.images) {
    block.images[{id.value + 50}] = image;
    set_pose(block, {id.value + 50}, pose_of(second, id));
  }
  for (const auto& [id, point] : second.points) block.points[{id.value + 5000}] = point;
  for (Observation observation : second.observations) {
    observation.image.value += 50;
    observation.point.value += 5000;
    block.observations.push_back(observation);
  }
  const auto adjusted = adjust(disturbed(block, 0.002, 0.05), {}, plain(), kRun);
  ASSERT_TRUE(adjusted);
  EXPECT_EQ(adjusted->rank_defect, 14);
  EXPECT_LT(adjusted->final_cost, 1e-12);
}

TEST(Adjust, ThreadsDoNotChangeABit) {
  const Block block = disturbed(
      test_block({.rows = 5, .columns = 6, .points = 1500, .sigma_px = 0.5, .position_sigma_m = 0.5}), 0.01, 0.3);
  ASSERT_GT(block.observations.size(), 9000u);  // three batches: otherwise threads are not used at all
  AdjustOptions options;
  options.calibration = Calibration::kBrown;
  collinea::Run one, three;
  three.threads = 3;
  const auto a = adjust(block, {}, options, one), b = adjust(block, {}, options, three);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->final_cost, b->final_cost);
  for (std::size_t i = 0; i < a->points.size(); ++i) ASSERT_EQ(a->points[i].second, b->points[i].second);
  for (const auto& [id, pose] : a->cam_from_world) EXPECT_EQ(pose.translation, b->cam_from_world.at(id).translation);
}

TEST(Adjust, LocalAdjustmentMovesOnlyWhatIsFree) {
  const Block truth = test_block({.rows = 3, .columns = 5});
  Block start = truth;
  AdjustScope scope;
  scope.free_images.emplace();
  Random random(2);
  for (const std::uint32_t id : {12u, 13u}) {
    scope.free_images->insert({id});
    const Rigid3 pose = pose_of(start, {id});
    const Eigen::Vector3d centre = centre_of(pose) + 0.5 * normal3(random);
    set_pose(start, {id}, {pose.rotation, -(pose.rotation * centre)});
  }
  const auto adjusted = adjust(start, scope, plain(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->cam_from_world.size(), 2u);
  EXPECT_EQ(adjusted->rank_defect, 0);
  EXPECT_LT(largest_centre_error(*adjusted, truth), 1e-6);
  EXPECT_LT(adjusted->points.size(), truth.points.size());
  std::set<PointId> seen;
  for (const Observation& observation : start.observations)
    if (scope.free_images->contains(observation.image)) seen.insert(observation.point);
  for (const auto& [id, position] : adjusted->points) EXPECT_TRUE(seen.contains(id));
  apply(*adjusted, start);
  EXPECT_EQ(pose_of(start, {10}).translation, pose_of(truth, {10}).translation);
}

TEST(Adjust, FixedPointsOrientImages) {  // resection
  const Block truth = test_block();
  AdjustScope scope;
  for (const auto& [id, point] : truth.points) scope.fixed_points.insert(id);
  const Block start = disturbed(truth, 0.01, 0.5);
  Block exact_points = start;
  exact_points.points = truth.points;
  const auto adjusted = adjust(exact_points, scope, plain(Calibration::kFocal), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->points.empty());
  EXPECT_EQ(adjusted->rank_defect, 0);
  EXPECT_LT(largest_centre_error(*adjusted, truth), 1e-6);
}

TEST(Adjust, PointsAloneAreAdjustedToTheEnd) {
  const Block truth = test_block();
  AdjustScope scope;
  for (const auto& [id, pose] : oriented_images(truth)) scope.fixed_images.insert(id);
  Block start = truth;
  Random random(6);
  for (auto& [id, point] : start.points) point.position_in_world += 12 * normal3(random);
  const auto adjusted = adjust(start, scope, {.calibration = Calibration::kNone}, kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->converged);
  EXPECT_TRUE(adjusted->cam_from_world.empty());
  for (const auto& [id, position] : adjusted->points)
    EXPECT_LT((position - truth.points.at(id).position_in_world).norm(), 1e-4);
}

TEST(Adjust, ACameraAloneIsAdjustedToTheEnd) {
  const Block truth = test_block();
  AdjustScope scope;
  for (const auto& [id, pose] : oriented_images(truth)) scope.fixed_images.insert(id);
  for (const auto& [id, point] : truth.points) scope.fixed_points.insert(id);
  Block start = truth;
  Camera& camera = start.cameras.begin()->second;
  camera.prior.sigma_f_px = 1e6;
  camera.params[Camera::kF] += 200;
  camera.params[Camera::kK1] = camera.params[Camera::kK2] = 0;
  for (Observation& seen : start.observations) seen.sigma_px = 1e-3;  // the pseudo-observations shall not count
  const auto adjusted = adjust(start, scope, {}, kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->converged);
  const Camera& exact = truth.cameras.begin()->second;
  EXPECT_NEAR(adjusted->cameras.begin()->second.params[Camera::kF], exact.params[Camera::kF], 1e-3);
  EXPECT_NEAR(adjusted->cameras.begin()->second.params[Camera::kK1], exact.params[Camera::kK1], 1e-5);
}

TEST(Adjust, VerticalsHoldTheRotationThatPositionsOnOneLineLeaveOpen) {
  Block truth = test_block({.rows = 1, .columns = 8, .tilt_rad = 0.3});
  AdjustScope scope;
  std::uint32_t number = 0;
  for (auto [id, pose] : oriented_images(truth)) {  // on an exact line; the measurements are made anew
    pose.translation = -(pose.rotation * Eigen::Vector3d(12.0 * number++, 0, 60));
    truth.images.at(id).position = PositionPrior{centre_of(pose), Eigen::Vector3d::Constant(0.2)};
    scope.verticals[id] = {pose.rotation * Eigen::Vector3d::UnitZ(), 0.02};
    set_pose(truth, id, pose);
  }
  for (Observation& seen : truth.observations) {
    const auto pixel = project(truth.camera_of(seen.image),
                               pose_of(truth, seen.image) * truth.points.at(seen.point).position_in_world);
    ASSERT_TRUE(pixel);
    seen.pixel = *pixel;
  }
  const Block start = disturbed(truth, 0.03, 0);  // the line stays one
  const auto without = adjust(start, {}, plain(), kRun), with = adjust(start, scope, plain(), kRun);
  ASSERT_TRUE(without && with);
  EXPECT_EQ(without->rank_defect, 1);
  EXPECT_EQ(with->rank_defect, 0);
  EXPECT_EQ(with->observation_count, without->observation_count + 16);
  EXPECT_TRUE(with->datum.attitudes);
  EXPECT_TRUE(with->converged);
  EXPECT_LT(with->iterations, 15);
  EXPECT_LT(with->sigma0, 1e-5);
  EXPECT_LT(largest_centre_error(*with, truth), 1e-4);
  for (const auto& [id, pose] : with->cam_from_world)
    EXPECT_LT(pose.rotation.angularDistance(pose_of(truth, id).rotation), 1e-6);
}

TEST(Adjust, HeightOnlyControlFixesOnlyHeights) {
  Block block = test_block({.control = 9});
  for (auto& [id, control] : block.control)
    control.sigma_m.head<2>().setConstant(std::numeric_limits<double>::infinity());
  const auto adjusted = adjust(block, {}, plain(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->rank_defect, 3);  // two shifts and the turn about the vertical; relief fixes the scale
  for (const ControlDifference& control : adjusted->control) {
    EXPECT_TRUE(std::isnan(control.difference_m.x()) && std::isnan(control.difference_m.y()));
    EXPECT_TRUE(std::isfinite(control.difference_m.z()));
  }
}

TEST(Adjust, SaysWhatIsIllPosed) {
  const auto code = [](const auto& result) { return result ? std::optional<Errc>() : result.error().code; };
  EXPECT_EQ(code(adjust(Block{}, {}, {}, kRun)), Errc::kIllPosed);
  Block no_observations = test_block();
  no_observations.observations.clear();
  EXPECT_EQ(code(adjust(no_observations, {}, {}, kRun)), Errc::kIllPosed);
  Block four_points = test_block({.rows = 1, .columns = 2});
  std::erase_if(four_points.observations, [](const Observation& o) { return o.point.value > 106; });
  EXPECT_EQ(code(adjust(four_points, {}, plain(Calibration::kBrown), kRun)), Errc::kIllPosed);
  Block no_sigma = test_block();
  no_sigma.observations[3].sigma_px = 0;
  EXPECT_EQ(code(adjust(no_sigma, {}, {}, kRun)), Errc::kBadInput);
  EXPECT_EQ(code(adjust(test_block(), {}, {.loss_scale_sigmas = 0}, kRun)), Errc::kBadInput);
  std::stop_source stop;
  stop.request_stop();
  collinea::Run stopped;
  stopped.stop = stop.get_token();
  EXPECT_EQ(code(adjust(test_block(), {}, {}, stopped)), Errc::kCancelled);
}

// One position is 20 cm off, ten of its sigmas: Huber's loss sets in at one and a half times what is asked for rays.
TEST(Adjust, TheScaleOfTheLossReachesPositions) {
  Block block = test_block({.sigma_px = 0.5, .position_sigma_m = 0.02});
  const ImageId wrong{14};
  block.images.at(wrong).position->position_in_world.x() += 0.2;
  for (const double scale : {1.0, 2.0, 1000.0}) {
    AdjustOptions options{.loss_scale_sigmas = scale};
    const auto adjusted = adjust(block, {}, options, kRun);
    ASSERT_TRUE(adjusted);
    for (const auto& one : adjusted->positions) {
      if (one.image != wrong) continue;
      const double sigmas = one.difference_m.norm() / 0.02;
      EXPECT_GT(sigmas, 5) << scale;
      EXPECT_NEAR(one.weight, std::min(1.0, 1.5 * scale / sigmas), 1e-6) << scale;
    }
  }
}

TEST(Adjust, ThousandsOfCamerasAreRefusedInWords) {
  Block block = test_block({.rows = 20, .columns = 51, .points = 30, .spacing_m = 1});
  std::uint32_t number = 100;
  for (auto& [id, image] : block.images) {
    block.cameras[CameraId{number}] = block.cameras.at(CameraId{1});
    image.camera = CameraId{number++};
  }
  const auto refused = adjust(block, {}, plain(Calibration::kBrownAffinity), kRun);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kUnsupported);
  EXPECT_NE(refused.error().message.find("1020 cameras with 10200 unknowns"), std::string::npos)
      << refused.error().message;
}

TEST(Adjust, LonelyRaysAndImagesAreLeftOut) {
  Block block = test_block({.control = 6});
  const ImageId lonely{10};
  std::erase_if(block.observations, [&](const Observation& o) { return o.image == lonely; });
  std::erase_if(block.control_observations, [&](const ControlObservation& o) { return o.image == lonely; });
  block.points[{999999}].position_in_world = {1, 2, 3};
  block.observations.push_back({{12}, {999999}, 0, {100, 100}, 1});
  const auto adjusted = adjust(block, {}, plain(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->images_left_out, std::vector<ImageId>{lonely});
  EXPECT_FALSE(adjusted->cam_from_world.contains(lonely));
  for (const auto& [id, position] : adjusted->points) EXPECT_NE(id, PointId{999999});
  std::map<PointId, int> rays;
  for (const Observation& observation : block.observations) ++rays[observation.point];
  std::size_t expected = 0;
  for (const auto& [id, count] : rays) expected += count >= 2 ? count : 0;
  EXPECT_EQ(adjusted->observations.size(), expected);
}

TEST(AdjustScope, FirstCamerasThatAreNamedStayAndTheOthersAreThoseOfNow) {
  AdjustScope scope;
  scope.first_cameras[{1}].name = "given";
  Camera named, other;
  named.name = other.name = "now";
  scope = with_first_cameras(scope, {{{1}, named}, {{2}, other}});
  ASSERT_EQ(scope.first_cameras.size(), 2u);
  EXPECT_EQ(scope.first_cameras.at({1}).name, "given");
  EXPECT_EQ(scope.first_cameras.at({2}).name, "now");
}

}  // namespace
}  // namespace collinea
