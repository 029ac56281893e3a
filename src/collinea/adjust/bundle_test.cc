// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/bundle.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numeric>

#include "collinea/adjust/linearise.h"
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
  EXPECT_EQ(adjusted->datum, "control points");
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
  first.sigma_f_px = 1e6;
  start.cameras.begin()->second = first;
  for (auto& observation : start.observations) observation.sigma_px = 1e-4;  // the weak observations shall not count
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
    EXPECT_EQ(adjusted->datum, "control points, camera positions");
  }
}

/// Mean over independent blocks and its standard deviation, from their own spread: unknowns of one block are
/// correlated.
struct Series {
  std::vector<double> values;
  double mean() const { return std::accumulate(values.begin(), values.end(), 0.0) / double(values.size()); }
  double sigma_of_mean() const {
    double squared = 0;
    for (const double value : values) squared += (value - mean()) * (value - mean());
    return std::sqrt(squared / double(values.size() - 1) / double(values.size()));
  }
};

// e' C^-1 e of the poses, their mean.
double squared_pose_error(const Adjusted& adjusted, const Block& truth) {
  double sum = 0;
  for (const auto& [id, pose] : adjusted.cam_from_world) {
    const Rigid3& exact = truth.cam_from_world.at(id);
    Eigen::Matrix<double, 6, 1> error;
    error << rotation_vector(pose.rotation.conjugate() * exact.rotation), centre_of(exact) - centre_of(pose);
    sum += error.dot(adjusted.pose_covariance.at(id).inverse() * error);
  }
  return sum / double(adjusted.cam_from_world.size());
}

// e' C^-1 e is chi-squared with 6 (pose), 3 (point) and 1 (f) degrees of freedom, so these are its means. Four standard
// deviations of the mean: one false alarm in 16,000 seeds. A covariance of poses 10 % too large or small fails.
TEST(Adjust, CovarianceMatchesTheRealErrors) {
  AdjustOptions options = plain(Calibration::kFocal);
  options.point_covariances = true;
  Series poses, points, focal;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 3, .points = 60, .seed = seed});
    AdjustScope scope;
    const auto adjusted = adjust(measured_anew(truth, scope, seed), scope, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    ASSERT_EQ(adjusted->undetermined, "");
    poses.values.push_back(squared_pose_error(*adjusted, truth));
    double sum = 0;
    for (std::size_t i = 0; i < adjusted->points.size(); ++i) {
      const Eigen::Vector3d error =
          adjusted->points[i].second - truth.points.at(adjusted->points[i].first).position_in_world;
      sum += error.dot(adjusted->point_covariance[i].inverse() * error);
    }
    points.values.push_back(sum / double(adjusted->points.size()));
    const double error =
        adjusted->cameras.at(CameraId{1}).params[Camera::kF] - truth.cameras.at(CameraId{1}).params[Camera::kF];
    focal.values.push_back(error * error / adjusted->camera_covariance.at(CameraId{1})(Camera::kF, Camera::kF));
  }
  EXPECT_NEAR(poses.mean(), 6, 4 * poses.sigma_of_mean());
  EXPECT_LT(4 * poses.sigma_of_mean(), 0.6);
  EXPECT_NEAR(points.mean(), 3, 4 * points.sigma_of_mean());
  EXPECT_LT(4 * points.sigma_of_mean(), 0.5);
  EXPECT_NEAR(focal.mean(), 1, 4 * focal.sigma_of_mean());
}

// Points measured without error in the adjusted images are off by what Adjusted::places says, and by nothing else:
// chi-squared with 3 degrees of freedom, as above.
TEST(Adjust, PlacesMeasuredWithoutErrorAreAsFarOffAsTheImagesMakeThem) {
  AdjustOptions options = plain(Calibration::kFocal);
  options.covariances = true;
  Series places;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 3, .points = 60, .seed = seed});
    AdjustScope scope;
    const auto adjusted = adjust(measured_anew(truth, scope, seed), scope, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    ASSERT_GT(adjusted->places.size(), 20u);
    Block exact = truth;  // its measurements have no errors
    apply(*adjusted, exact);
    AdjustScope held;
    for (const auto& [id, pose] : exact.cam_from_world) held.fixed_images.insert(id);
    const auto intersected = adjust(exact, held, plain(), kRun);
    ASSERT_TRUE(intersected) << intersected.error().message;
    const std::map<PointId, Eigen::Vector3d> found(intersected->points.begin(), intersected->points.end());
    double sum = 0;
    int count = 0;
    for (const PlacePrecision& place : adjusted->places)
      for (const auto& [id, position] : adjusted->points) {
        if (position != place.position_in_world) continue;
        const Eigen::Vector3d error = found.at(id) - truth.points.at(id).position_in_world;
        sum += error.dot(place.covariance_m2.inverse() * error);
        ++count;
      }
    ASSERT_EQ(count, int(adjusted->places.size()));
    places.values.push_back(sum / count);
  }
  EXPECT_NEAR(places.mean(), 3, 4 * places.sigma_of_mean());
  EXPECT_LT(4 * places.sigma_of_mean(), 0.6);
}

// Errors of Student's distribution with three degrees of freedom and the loss that goes with it: the whitened errors of
// poses in a free block, times sigma0, are as long as their covariance says. Without sigma0 they would be
// 1.5 times too long.
TEST(Adjust, Sigma0TurnsCovariancesOfARobustEstimateIntoTrueOnes) {
  AdjustOptions options{.calibration = Calibration::kNone,
                        .loss = Loss::kCauchy,
                        .loss_scale_sigmas = std::sqrt(5.0),
                        .covariances = true};
  Series poses, bare;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 3, .points = 100, .seed = seed});
    Block block = truth;
    Random random(seed, 5);
    for (Observation& observation : block.observations) {
      double chi2 = 0;
      for (int k = 0; k < 3; ++k) chi2 += std::pow(random.normal(), 2);
      const double u = random.normal(), v = random.normal();
      observation.pixel += 0.3 * std::sqrt(3 / chi2) * Eigen::Vector2d(u, v);
      observation.sigma_px = 0.3 * std::sqrt(3.0 / 5);
    }
    AdjustScope scope{.fixed_images = {block.images.begin()->first, block.images.rbegin()->first}};
    const auto adjusted = adjust(block, scope, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    bare.values.push_back(squared_pose_error(*adjusted, truth));
    poses.values.push_back(bare.values.back() / std::pow(adjusted->sigma0, 2));
  }
  EXPECT_NEAR(poses.mean(), 6, 6 * 0.21);  // a tenth of the sigmas: the correction holds for many rays a point
  EXPECT_LT(4 * poses.sigma_of_mean(), 0.8);
  EXPECT_GT(bare.mean(), 6 + 4 * bare.sigma_of_mean());
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

TEST(Adjust, FreeNetworkHasSevenDefectsAndResidualsThatDoNotDependOnTheFrame) {
  const Block block = test_block({.rows = 2, .points = 80, .sigma_px = 0.5});
  const Similarity3 moved_from_world{0.37, rotation_by({0.5, -1, 0.3}), {40, 8, -11}};
  Block other = block;
  for (auto& [id, pose] : other.cam_from_world) pose = moved(pose, moved_from_world);
  for (auto& [id, point] : other.points) point.position_in_world = moved_from_world * point.position_in_world;
  AdjustOptions options = plain();
  options.covariances = true;
  const auto a = adjust(block, {}, options, kRun), b = adjust(other, {}, options, kRun);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->rank_defect, 7);
  EXPECT_EQ(a->undetermined, "");
  EXPECT_EQ(a->pose_covariance.size(), block.images.size());
  EXPECT_NE(a->datum.find("free network"), std::string::npos);
  ASSERT_EQ(a->residuals_px.size(), block.observations.size());
  for (std::size_t i = 0; i < a->residuals_px.size(); ++i)
    EXPECT_LT((a->residuals_px[i] - b->residuals_px[i]).norm(), 1e-5);
  EXPECT_NEAR(a->sigma0, 1, 4 / std::sqrt(2.0 * double(a->redundancy)));
}

TEST(Adjust, TwoUnconnectedPartsHaveFourteenDefects) {
  Block block = test_block({.rows = 1, .columns = 3, .points = 60});
  const Block second = test_block({.rows = 1, .columns = 3, .points = 60, .seed = 5});
  for (const auto& [id, image] : second.images) {
    block.images[{id.value + 50}] = image;
    block.cam_from_world[{id.value + 50}] = second.cam_from_world.at(id);
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

TEST(Adjust, ThreadsDoNotChangeABitOfTheStatistics) {
  const Block block = disturbed(
      test_block({.rows = 5, .columns = 6, .points = 1500, .sigma_px = 0.5, .position_sigma_m = 0.5, .control = 9}),
      0.01, 0.3);
  AdjustOptions options;
  options.point_covariances = options.reliability = true;
  collinea::Run one, three;
  three.threads = 3;
  const auto a = adjust(block, {}, options, one), b = adjust(block, {}, options, three);
  ASSERT_TRUE(a && b && a->reliability && b->reliability);
  EXPECT_EQ(a->sigma0, b->sigma0);
  for (const auto& [id, covariance] : a->pose_covariance) EXPECT_EQ(covariance, b->pose_covariance.at(id));
  for (const auto& [id, covariance] : a->camera_covariance) EXPECT_EQ(covariance, b->camera_covariance.at(id));
  ASSERT_FALSE(a->point_covariance.empty());
  for (std::size_t i = 0; i < a->point_covariance.size(); ++i)
    ASSERT_EQ(a->point_covariance[i], b->point_covariance[i]);
  for (std::size_t i = 0; i < a->control.size(); ++i)
    EXPECT_EQ(a->control[i].difference_sigma_m, b->control[i].difference_sigma_m);
  for (std::size_t i = 0; i < a->reliability->tie_redundancy.size(); ++i)
    ASSERT_EQ(a->reliability->tie_redundancy[i], b->reliability->tie_redundancy[i]);
  ASSERT_EQ(a->reliability->others.size(), b->reliability->others.size());
  for (std::size_t i = 0; i < a->reliability->others.size(); ++i)
    EXPECT_EQ(a->reliability->others[i].w, b->reliability->others[i].w);
}

TEST(Adjust, LocalAdjustmentMovesOnlyWhatIsFree) {
  const Block truth = test_block({.rows = 3, .columns = 5});
  Block start = truth;
  AdjustScope scope;
  scope.free_images.emplace();
  Random random(2);
  for (const std::uint32_t id : {12u, 13u}) {
    scope.free_images->insert({id});
    Rigid3& pose = start.cam_from_world.at({id});
    const Eigen::Vector3d centre = centre_of(pose) + 0.5 * normal3(random);
    pose.translation = -(pose.rotation * centre);
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
  EXPECT_EQ(start.cam_from_world.at({10}).translation, truth.cam_from_world.at({10}).translation);
}

TEST(Adjust, HeldPointsOrientImages) {  // resection
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
  for (const auto& [id, pose] : truth.cam_from_world) scope.fixed_images.insert(id);
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
  for (const auto& [id, pose] : truth.cam_from_world) scope.fixed_images.insert(id);
  for (const auto& [id, point] : truth.points) scope.fixed_points.insert(id);
  Block start = truth;
  Camera& camera = start.cameras.begin()->second;
  camera.sigma_f_px = 1e6;
  camera.params[Camera::kF] += 200;
  camera.params[Camera::kK1] = camera.params[Camera::kK2] = 0;
  for (Observation& seen : start.observations) seen.sigma_px = 1e-3;  // the weak observations shall not count
  const auto adjusted = adjust(start, scope, {}, kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->converged);
  const Camera& exact = truth.cameras.begin()->second;
  EXPECT_NEAR(adjusted->cameras.begin()->second.params[Camera::kF], exact.params[Camera::kF], 1e-3);
  EXPECT_NEAR(adjusted->cameras.begin()->second.params[Camera::kK1], exact.params[Camera::kK1], 1e-5);
}

TEST(Adjust, VerticalsHoldTheTurnThatPositionsOnOneLineLeaveOpen) {
  Block truth = test_block({.rows = 1, .columns = 8, .tilt_rad = 0.3});
  AdjustScope scope;
  std::uint32_t number = 0;
  for (auto& [id, pose] : truth.cam_from_world) {  // on an exact line; the measurements are made anew
    pose.translation = -(pose.rotation * Eigen::Vector3d(12.0 * number++, 0, 60));
    truth.images.at(id).position = PositionPrior{centre_of(pose), Eigen::Vector3d::Constant(0.2)};
    scope.verticals[id] = {pose.rotation * Eigen::Vector3d::UnitZ(), 0.02};
  }
  for (Observation& seen : truth.observations) {
    const auto pixel = project(truth.camera_of(seen.image),
                               truth.cam_from_world.at(seen.image) * truth.points.at(seen.point).position_in_world);
    ASSERT_TRUE(pixel);
    seen.pixel = *pixel;
  }
  const Block start = disturbed(truth, 0.03, 0);  // the line stays one
  const auto without = adjust(start, {}, plain(), kRun), with = adjust(start, scope, plain(), kRun);
  ASSERT_TRUE(without && with);
  EXPECT_EQ(without->rank_defect, 1);
  EXPECT_EQ(with->rank_defect, 0);
  EXPECT_EQ(with->observation_count, without->observation_count + 16);
  EXPECT_NE(with->datum.find("attitudes"), std::string::npos) << with->datum;
  EXPECT_TRUE(with->converged);
  EXPECT_LT(with->iterations, 15);
  EXPECT_LT(with->sigma0, 1e-5);
  EXPECT_LT(largest_centre_error(*with, truth), 1e-4);
  for (const auto& [id, pose] : with->cam_from_world)
    EXPECT_LT(pose.rotation.angularDistance(truth.cam_from_world.at(id).rotation), 1e-6);
}

TEST(Adjust, TheSigmaOfATurnIsThatOfItsVerticals) {
  Block block = test_block({.rows = 1, .columns = 8, .sigma_px = 0.1});
  AdjustScope scope;
  std::uint32_t number = 0;
  for (const auto& [id, pose] : block.cam_from_world) {
    // All the positions can tell of the turn about the line is put out of reach.
    block.images.at(id).position = PositionPrior{centre_of(pose), {0.2, 1e4, 1e4}};
    scope.verticals[id] = {pose.rotation * Eigen::Vector3d::UnitZ(), 0.02};
    ++number;
  }
  AdjustOptions options = plain();
  options.covariances = true;
  const auto adjusted = adjust(block, scope, options, kRun);
  ASSERT_TRUE(adjusted);
  for (const auto& [id, covariance] : adjusted->pose_covariance)
    EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.02 / std::sqrt(number), 0.001);
  scope.verticals.begin()->second.sigma_rad = 0;
  EXPECT_EQ(adjust(block, scope, options, kRun).error().code, Errc::kBadInput);
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

// What is not given may be no number; what is given must be one.
TEST(Adjust, CoordinatesThatAreNotGivenNeedNotBeNumbers) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN(), kInfinity = std::numeric_limits<double>::infinity();
  const Block truth = test_block({.sigma_px = 0.5, .position_sigma_m = 0.1, .control = 9});
  Block not_given = truth, no_number = truth;
  for (Block* block : {&not_given, &no_number}) {
    block->control.begin()->second.sigma_m.z() = kInfinity;
    block->images.begin()->second.position->sigma_m.z() = kInfinity;
  }
  no_number.control.begin()->second.position_in_world.z() = kNaN;
  no_number.images.begin()->second.position->position_in_world.z() = kNaN;
  AdjustOptions options = plain();
  options.reliability = true;
  const auto expected = adjust(not_given, {}, options, kRun), is = adjust(no_number, {}, options, kRun);
  ASSERT_TRUE(expected && is);
  EXPECT_EQ(is->sigma0, expected->sigma0);
  EXPECT_TRUE(is->reliability);
  EXPECT_TRUE(std::isnan(is->positions.front().difference_m.z()));
  for (const auto& [id, pose] : is->cam_from_world)
    EXPECT_EQ(pose.translation, expected->cam_from_world.at(id).translation);
  for (const bool control : {true, false}) {
    Block wrong = truth;
    (control ? wrong.control.begin()->second.position_in_world.z()
             : wrong.images.begin()->second.position->position_in_world.z()) = kNaN;
    const auto refused = adjust(wrong, {}, options, kRun);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
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

// An image that too little determines stands anywhere; check points are not judged by it.
TEST(Adjust, CheckPointsDoNotUseImagesThatAreLeftOut) {
  Block block = test_block({.control = 9});
  const ControlId check{2};
  ASSERT_EQ(block.control.at(check).role, ControlRole::kCheck);
  const auto seen = std::find_if(block.control_observations.begin(), block.control_observations.end(),
                                 [&](const ControlObservation& o) { return o.point == check; });
  ASSERT_NE(seen, block.control_observations.end());
  const ImageId lonely = seen->image;
  const auto place = std::size_t(seen - block.control_observations.begin());
  std::erase_if(block.observations, [&](const Observation& o) { return o.image == lonely; });
  for (ControlObservation& o : block.control_observations)
    if (o.image == lonely && o.point != check) o.image = ImageId{999};  // not oriented
  block.images[ImageId{999}] = block.images.at(lonely);
  Rigid3& pose = block.cam_from_world.at(lonely);
  pose.translation += Eigen::Vector3d(2, -1, 0);
  AdjustOptions options = plain();
  options.covariances = true;
  const auto adjusted = adjust(block, {}, options, kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->images_left_out, std::vector<ImageId>{lonely});
  Block without = block;
  without.cam_from_world.erase(lonely);
  const auto expected = adjust(without, {}, options, kRun);
  ASSERT_TRUE(expected) << expected.error().message;
  ASSERT_EQ(adjusted->control.size(), expected->control.size());
  EXPECT_TRUE(std::isnan(adjusted->control_residuals_px[place].x()));
  for (std::size_t i = 0; i < expected->control.size(); ++i) {
    const ControlDifference &is = adjusted->control[i], &should = expected->control[i];
    EXPECT_EQ(is.rays, should.rays);
    EXPECT_LT(is.difference_m.norm(), 1e-6);
    EXPECT_LT((*is.covariance_m2 - *should.covariance_m2).norm(), 1e-6 * should.covariance_m2->norm());
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

}  // namespace
}  // namespace collinea
