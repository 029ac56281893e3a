// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/examine.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <numeric>

#include "collinea/adjust/point_normals.h"
#include "collinea/geometry/rotation.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::disturbed;
using testing::examined;
using testing::measured_anew;
using testing::normal3;
using testing::test_block;

const Run kRun;

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
double squared_pose_error(const Examined& adjusted, const Block& truth) {
  double sum = 0;
  for (const auto& [id, pose] : adjusted.cam_from_world) {
    const Rigid3 exact = pose_of(truth, id);
    Eigen::Matrix<double, 6, 1> error;
    error << rotation_vector(pose.rotation.conjugate() * exact.rotation), centre_of(exact) - centre_of(pose);
    sum += error.dot(adjusted.pose_covariance.at(id).inverse() * error);
  }
  return sum / double(adjusted.cam_from_world.size());
}

// e' C^-1 e is chi-squared with 6 (pose), 3 (point) and 1 (f) degrees of freedom, so these are its means. Four standard
// deviations of the mean: one false alarm in 16,000 seeds. A covariance of poses 10 % too large or small fails.
TEST(Adjust, CovarianceMatchesTheRealErrors) {
  ExamineOptions options = examined(Calibration::kFocal);
  options.point_covariances = true;
  Series poses, points, focal;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 3, .points = 60, .seed = seed});
    AdjustScope scope;
    const auto adjusted = examine(measured_anew(truth, scope, seed), scope, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    ASSERT_FALSE(adjusted->undetermined);
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

// Points measured without error in the adjusted images are off by what Examined::point_precisions says, and by nothing
// else: chi-squared with 3 degrees of freedom, as above.
TEST(Adjust, PositionsMeasuredWithoutErrorAreAsFarOffAsTheImagesMakeThem) {
  ExamineOptions options = examined(Calibration::kFocal);
  Series points;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const Block truth = test_block({.rows = 2, .columns = 3, .points = 60, .seed = seed});
    AdjustScope scope;
    const auto adjusted = examine(measured_anew(truth, scope, seed), scope, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    ASSERT_GT(adjusted->point_precisions.size(), 20u);
    Block exact = truth;  // its measurements have no errors
    apply(*adjusted, exact);
    AdjustScope fixed;
    for (const auto& [id, pose] : oriented_images(exact)) fixed.fixed_images.insert(id);
    const auto intersected = examine(exact, fixed, examined(), kRun);
    ASSERT_TRUE(intersected) << intersected.error().message;
    const std::map<PointId, Eigen::Vector3d> found(intersected->points.begin(), intersected->points.end());
    double sum = 0;
    int count = 0;
    for (const PointPrecision& precision : adjusted->point_precisions)
      for (const auto& [id, position] : adjusted->points) {
        if (position != precision.position_in_world) continue;
        const Eigen::Vector3d error = found.at(id) - truth.points.at(id).position_in_world;
        sum += error.dot(precision.covariance_m2.inverse() * error);
        ++count;
      }
    ASSERT_EQ(count, int(adjusted->point_precisions.size()));
    points.values.push_back(sum / count);
  }
  EXPECT_NEAR(points.mean(), 3, 4 * points.sigma_of_mean());
  EXPECT_LT(4 * points.sigma_of_mean(), 0.6);
}

// Errors of Student's distribution with three degrees of freedom and the loss that goes with it: the whitened errors of
// poses in a free block, times sigma0, are as long as their covariance says. Without sigma0 they would be
// 1.5 times too long.
TEST(Adjust, Sigma0TurnsCovariancesOfARobustEstimateIntoTrueOnes) {
  ExamineOptions options{
      .adjust = {.calibration = Calibration::kNone, .loss = Loss::kCauchy, .loss_scale_sigmas = std::sqrt(5.0)}};
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
    const auto adjusted = examine(block, scope, options, kRun);
    ASSERT_TRUE(adjusted) << adjusted.error().message;
    bare.values.push_back(squared_pose_error(*adjusted, truth));
    poses.values.push_back(bare.values.back() / std::pow(adjusted->sigma0, 2));
  }
  EXPECT_NEAR(poses.mean(), 6, 6 * 0.21);  // a tenth of the sigmas: the correction holds for many rays a point
  EXPECT_LT(4 * poses.sigma_of_mean(), 0.8);
  EXPECT_GT(bare.mean(), 6 + 4 * bare.sigma_of_mean());
}

TEST(Adjust, FreeNetworkHasSevenDefectsAndResidualsThatDoNotDependOnTheFrame) {
  const Block block = test_block({.rows = 2, .points = 80, .sigma_px = 0.5});
  const Similarity3 moved_from_world{0.37, rotation_by({0.5, -1, 0.3}), {40, 8, -11}};
  Block other = block;
  for (const auto& [id, pose] : oriented_images(other)) set_pose(other, id, moved(pose, moved_from_world));
  for (auto& [id, point] : other.points) point.position_in_world = moved_from_world * point.position_in_world;
  ExamineOptions options = examined();
  const auto a = examine(block, {}, options, kRun), b = examine(other, {}, options, kRun);
  ASSERT_TRUE(a && b);
  EXPECT_EQ(a->rank_defect, 7);
  EXPECT_FALSE(a->undetermined);
  EXPECT_EQ(a->pose_covariance.size(), block.images.size());
  EXPECT_EQ(a->datum, DatumSources{.parts = 1});
  EXPECT_EQ(a->rank_defect, 7);
  ASSERT_EQ(a->residuals_px.size(), block.observations.size());
  for (std::size_t i = 0; i < a->residuals_px.size(); ++i)
    EXPECT_LT((a->residuals_px[i] - b->residuals_px[i]).norm(), 1e-5);
  EXPECT_NEAR(a->sigma0, 1, 4 / std::sqrt(2.0 * double(a->redundancy)));
}

TEST(Adjust, ThreadsDoNotChangeABitOfTheStatistics) {
  const Block block = disturbed(
      test_block({.rows = 5, .columns = 6, .points = 1500, .sigma_px = 0.5, .position_sigma_m = 0.5, .control = 9}),
      0.01, 0.3);
  ExamineOptions options;
  options.point_covariances = options.reliability = true;
  collinea::Run one, three;
  three.threads = 3;
  const auto a = examine(block, {}, options, one), b = examine(block, {}, options, three);
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

TEST(Adjust, TheSigmaOfATurnIsThatOfItsVerticals) {
  Block block = test_block({.rows = 1, .columns = 8, .sigma_px = 0.1});
  AdjustScope scope;
  std::uint32_t number = 0;
  for (const auto& [id, pose] : oriented_images(block)) {
    // All the positions can tell of the turn about the line is put out of reach.
    block.images.at(id).position = PositionPrior{centre_of(pose), {0.2, 1e4, 1e4}};
    scope.verticals[id] = {pose.rotation * Eigen::Vector3d::UnitZ(), 0.02};
    ++number;
  }
  ExamineOptions options = examined();
  const auto adjusted = examine(block, scope, options, kRun);
  ASSERT_TRUE(adjusted);
  for (const auto& [id, covariance] : adjusted->pose_covariance)
    EXPECT_NEAR(std::sqrt(covariance(0, 0)), 0.02 / std::sqrt(number), 0.001);
  scope.verticals.begin()->second.sigma_rad = 0;
  EXPECT_EQ(examine(block, scope, options, kRun).error().code, Errc::kBadInput);
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
  ExamineOptions options = examined();
  options.reliability = true;
  const auto expected = examine(not_given, {}, options, kRun), is = examine(no_number, {}, options, kRun);
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
    const auto refused = examine(wrong, {}, options, kRun);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, Errc::kBadInput);
  }
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
  const auto precision = std::size_t(seen - block.control_observations.begin());
  std::erase_if(block.observations, [&](const Observation& o) { return o.image == lonely; });
  for (ControlObservation& o : block.control_observations)
    if (o.image == lonely && o.point != check) o.image = ImageId{999};  // not oriented
  block.images[ImageId{999}] = block.images.at(lonely);
  Rigid3 pose = pose_of(block, lonely);
  pose.translation += Eigen::Vector3d(2, -1, 0);
  set_pose(block, lonely, pose);
  ExamineOptions options = examined();
  const auto adjusted = examine(block, {}, options, kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->images_left_out, std::vector<ImageId>{lonely});
  Block without = block;
  remove_pose(without, lonely);
  const auto expected = examine(without, {}, options, kRun);
  ASSERT_TRUE(expected) << expected.error().message;
  ASSERT_EQ(adjusted->control.size(), expected->control.size());
  EXPECT_TRUE(std::isnan(adjusted->control_residuals_px[precision].x()));
  for (std::size_t i = 0; i < expected->control.size(); ++i) {
    const ControlDifference &is = adjusted->control[i], &should = expected->control[i];
    EXPECT_EQ(is.rays, should.rays);
    EXPECT_LT(is.difference_m.norm(), 1e-6);
    EXPECT_LT((*is.covariance_m2 - *should.covariance_m2).norm(), 1e-6 * should.covariance_m2->norm());
  }
}

}  // namespace
}  // namespace collinea
