// SPDX-License-Identifier: Apache-2.0
// The motion of the ground as a whole: what is stated of it is what its real errors are.
#include "collinea/quality/internal/ground_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using bundle::GroundMotion;
using bundle::Matrix7;
using bundle::Vector7;

const Run kRun;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// New measurements and control coordinates of an exact world; the latter by their sigmas.
Block measured(Block block, std::uint64_t seed) {
  Random random(seed, 3);
  const auto measure = [&](auto& seen) {
    const double du = random.normal(), dv = random.normal();
    seen.pixel += 0.5 * Eigen::Vector2d(du, dv);
    seen.sigma_px = 0.5;
  };
  for (Observation& seen : block.observations) measure(seen);
  for (ControlObservation& seen : block.control_observations) measure(seen);
  for (auto& [id, control] : block.control) {
    const Eigen::Vector3d error = testing::normal3(random);
    for (int axis = 0; axis < 3; ++axis)
      if (std::isfinite(control.sigma_m[axis])) control.position_in_world[axis] += control.sigma_m[axis] * error[axis];
  }
  return block;
}

struct Moved {
  Vector7 motion;
  Matrix7 covariance;
};

// What the ground of an adjustment moved from the truth, and its covariance as stated.
Moved moved(const Block& block, const Block& truth, const AdjustOptions& options) {
  auto solved = solve_bundle(block, {}, options, kRun);
  EXPECT_TRUE(solved);
  const bundle::Problem& problem = solved->problem();
  const auto factored = solved->factor(kRun);
  EXPECT_TRUE(factored.factor);
  const auto motion = bundle::ground_motion(problem, solved->state(), *factored.factor);
  EXPECT_TRUE(motion);
  std::vector<Eigen::Vector3d> errors;
  for (const GroundMotion::Point& one : motion->points) {
    const bundle::ProblemPoint& point = problem.point(one.number);
    errors.push_back(Eigen::Vector3d(&solved->state().points[3 * one.number]) -
                     (point.control >= 0 ? truth.control.at(ControlId{point.id}).position_in_world
                                         : truth.points.at(PointId{point.id}).position_in_world));
  }
  return {motion->fitted_to(solved->state(), errors), motion->covariance};
}

// e' C+ e over the motions that are observed, of 200 blocks: chi-squared with as many degrees of freedom.
void expect_as_stated(const Block& truth, int degrees, Calibration calibration = Calibration::kNone) {
  constexpr int kBlocks = 200;
  double sum = 0;
  Matrix7 both = Matrix7::Zero(), stated = both;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Moved one = moved(measured(truth, seed), truth, testing::plain(calibration));
    const Eigen::SelfAdjointEigenSolver<Matrix7> eigen(one.covariance);
    for (int k = 7 - degrees; k < 7; ++k)
      sum += std::pow(eigen.eigenvectors().col(k).dot(one.motion), 2) / eigen.eigenvalues()[k];
    for (int k = 0; k < 7 - degrees; ++k) EXPECT_LT(std::abs(eigen.eigenvalues()[k]), 1e-9 * eigen.eigenvalues()[6]);
    both += one.motion * one.motion.transpose() / kBlocks;
    stated += one.covariance / kBlocks;
  }
  EXPECT_NEAR(sum / kBlocks, degrees, 4 * std::sqrt(2.0 * degrees / kBlocks));
  for (int k = 3; k < 7; ++k) {  // angles and scale by themselves
    if (degrees == 7) EXPECT_NEAR(both(k, k) / stated(k, k), 1, 4 * std::sqrt(2.0 / kBlocks)) << k;
  }
}

Block with_control(int points, double sigma_m) {
  Block block = testing::test_block(
      {.rows = 2, .columns = 3, .points = 40, .control = points, .control_sigma_m = sigma_m, .tilt_rad = 0.05});
  for (auto& [id, control] : block.control) control.role = ControlRole::kControl;
  return block;
}

TEST(GroundMotion, IsAsGoodAsStatedWithControlAllOver) { expect_as_stated(with_control(7, 0.01), 7); }

TEST(GroundMotion, IsAsGoodAsStatedWithPoorControlAndAFreeFocalLength) {
  expect_as_stated(with_control(4, 0.1), 7, Calibration::kFocal);
}

// Shift in plan and azimuth are nobody's; they are removed.
TEST(GroundMotion, IsAsGoodAsStatedWithHeightsAlone) {
  Block block = with_control(7, 0.01);
  for (auto& [id, control] : block.control) control.sigma_m.head<2>().setConstant(kInfinity);
  block.control.begin()->second.sigma_m.setConstant(0.01);  // which leaves the azimuth and the scale of the plan
  expect_as_stated(block, 6);
}

// Points far behind, of which hardly anything is known, count for hardly anything.
TEST(GroundMotion, PointsFarBehindDoNotBlurIt) {
  const Block near = with_control(7, 0.01);
  Block block = near;
  Random random(4);
  for (std::uint32_t i = 0; i < 10; ++i) {
    const PointId id{5000 + i};
    block.points[id].position_in_world = {random.uniform(-4000, 4000), random.uniform(-4000, 4000), -8000};
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = project(block.camera_of(image), pose * block.points.at(id).position_in_world);
          pixel && inside(block.camera_of(image), *pixel))
        block.observations.push_back({image, id, 0, *pixel, 1});
  }
  const Matrix7 alone = moved(near, near, testing::plain()).covariance,
                with = moved(block, block, testing::plain()).covariance;
  for (int k = 3; k < 7; ++k) EXPECT_LT(std::sqrt(with(k, k)), 2 * std::sqrt(alone(k, k))) << k;
}

TEST(GroundMotion, PointsOnALineTellNone) {
  Block block = with_control(7, 0.01);
  block.control.clear();
  block.control_observations.clear();
  for (auto& [id, point] : block.points) point.position_in_world = {0.3 * id.value, 10, 0};
  std::vector<Observation> seen;
  for (const auto& [id, point] : block.points)
    for (const auto& [image, pose] : oriented_images(block))
      if (const auto pixel = project(block.camera_of(image), pose * point.position_in_world);
          pixel && inside(block.camera_of(image), *pixel))
        seen.push_back({image, id, 0, *pixel, 1});
  for (auto& [id, image] : block.images)
    image.position = PositionPrior{centre_of(pose_of(block, id)), Eigen::Vector3d::Constant(0.02)};
  block.observations = seen;
  auto solved = solve_bundle(block, {}, testing::plain(), kRun);
  ASSERT_TRUE(solved);
  const auto factored = solved->factor_stiffened(1e-10, kRun);
  ASSERT_TRUE(factored.factor);
  EXPECT_FALSE(bundle::ground_motion(solved->problem(), solved->state(), *factored.factor));
}

}  // namespace
}  // namespace collinea
