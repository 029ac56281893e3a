// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/free_network.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <set>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::normal3;
using testing::test_block;

const Run kRun;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

ExamineOptions exactly() {
  ExamineOptions options{
      .adjust = {.calibration = Calibration::kNone, .loss = Loss::kNone, .position_loss = Loss::kNone}};
  options.adjust.relative_cost_change = options.adjust.parameter_change = 1e-13;
  options.adjust.step_sigmas = 1e-3;
  options.point_covariances = true;
  return options;
}

// Control points without coordinates, and check points, which take no part.
Block free_block(std::uint64_t seed) {
  Block block = test_block({.rows = 2, .columns = 3, .points = 40, .control = 9, .seed = seed});
  for (auto& [id, control] : block.control)
    if (control.role == ControlRole::kControl) control.sigma_m.setConstant(kInfinity);
  return block;
}

Block measured(Block block, std::uint64_t seed) {
  Random random(seed, 3);
  const auto measure = [&](auto& seen) {
    const double du = random.normal(), dv = random.normal();
    seen.pixel += 0.5 * Eigen::Vector2d(du, dv);
    seen.sigma_px = 0.5;
  };
  for (Observation& seen : block.observations) measure(seen);
  for (ControlObservation& seen : block.control_observations) measure(seen);
  return block;
}

using Vector7 = Eigen::Matrix<double, 7, 1>;

Eigen::Matrix<double, 3, 7> motion(const Eigen::Vector3d& position) {
  Eigen::Matrix<double, 3, 7> g;
  g << Eigen::Matrix3d::Identity(), -skew(position), position;
  return g;
}

// The motion of the whole that fits the errors of the tie points best; of these alone, where some are given.
Vector7 motion_of_errors(const Examined& adjusted, const Block& truth, const std::set<PointId>& of = {}) {
  Eigen::Matrix<double, 7, 7> normals = Eigen::Matrix<double, 7, 7>::Zero();
  Vector7 right = Vector7::Zero();
  for (const auto& [id, position] : adjusted.points) {
    if (!of.empty() && !of.contains(id)) continue;
    const auto g = motion(position);
    normals += g.transpose() * g;
    right += g.transpose() * (truth.points.at(id).position_in_world - position);
  }
  return normals.inverse() * right;
}

class MeanSquare {
 public:
  void add(const Eigen::VectorXd& error, const Eigen::MatrixXd& covariance) {
    block_ += error.dot(covariance.inverse() * error) / static_cast<double>(error.size());
    ++count_;
  }
  void end_block() {
    sum_ += block_ / count_;
    squares_ += std::pow(block_ / count_, 2);
    ++blocks_;
    block_ = count_ = 0;
  }
  void expect_one(const char* what) const {
    const double mean = sum_ / blocks_, deviation = std::sqrt((squares_ / blocks_ - mean * mean) / blocks_);
    EXPECT_NEAR(mean, 1, 4 * deviation) << what;
    EXPECT_LT(4 * deviation, 0.2) << what;
  }

 private:
  double block_ = 0, count_ = 0, sum_ = 0, squares_ = 0, blocks_ = 0;
};

// Once the motion of all tie points is taken off, errors are as long as the covariances say: of images, of tie points,
// of control points without coordinates and of check points alike. All are in one datum.
TEST(FreeNetwork, ErrorsAreAsStatedInTheDatumOfTheTiePoints) {
  MeanSquare poses, points, control, checks;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const Block truth = free_block(seed);
    const auto adjusted = examine(measured(truth, seed), {}, exactly(), kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    ASSERT_EQ(adjusted->rank_defect, 7);
    const Vector7 whole = motion_of_errors(*adjusted, truth);
    const double variance = std::pow(sigma_scale(*adjusted), 2);
    for (const auto& [id, pose] : adjusted->cam_from_world) {
      const Rigid3& exact = pose_of(truth, id);
      const Eigen::Vector3d centre = centre_of(pose);
      Eigen::Matrix<double, 6, 1> error;
      error << rotation_vector(pose.rotation.conjugate() * exact.rotation) + whole.segment<3>(3),
          centre_of(exact) - centre - motion(centre) * whole;
      poses.add(error, variance * adjusted->pose_covariance.at(id));
    }
    const auto error_at = [&](const Eigen::Vector3d& exact, const Eigen::Vector3d& position) {
      return Eigen::Vector3d(exact - position - motion(position) * whole);
    };
    for (std::size_t i = 0; i < adjusted->points.size(); ++i) {
      const auto& [id, position] = adjusted->points[i];
      points.add(error_at(truth.points.at(id).position_in_world, position), variance * adjusted->point_covariance[i]);
    }
    for (const ControlDifference& one : adjusted->control) {
      if (!one.covariance_m2) continue;
      (one.used ? control : checks)
          .add(error_at(truth.control.at(one.point).position_in_world, *one.position_in_world),
               variance * *one.covariance_m2);
    }
    for (MeanSquare* one : {&poses, &points, &control, &checks}) one->end_block();
  }
  poses.expect_one("poses");
  points.expect_one("tie points");
  control.expect_one("control points");
  checks.expect_one("check points");
}

// The datum may be that of a few points by name: errors are as stated once their motion is taken off.
TEST(FreeNetwork, ErrorsAreAsStatedInTheDatumOfChosenPoints) {
  MeanSquare poses, points;
  for (std::uint64_t seed = 1; seed <= 150; ++seed) {
    const Block truth = free_block(seed);
    ExamineOptions options = exactly();
    for (const auto& [id, point] : truth.points)
      if (options.datum.ties.size() < 6) options.datum.ties.insert(id);
    const auto adjusted = examine(measured(truth, seed), {}, options, kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    const Vector7 whole = motion_of_errors(*adjusted, truth, options.datum.ties);
    const double variance = std::pow(sigma_scale(*adjusted), 2);
    for (const auto& [id, pose] : adjusted->cam_from_world) {
      const Rigid3& exact = pose_of(truth, id);
      const Eigen::Vector3d centre = centre_of(pose);
      Eigen::Matrix<double, 6, 1> error;
      error << rotation_vector(pose.rotation.conjugate() * exact.rotation) + whole.segment<3>(3),
          centre_of(exact) - centre - motion(centre) * whole;
      poses.add(error, variance * adjusted->pose_covariance.at(id));
    }
    for (std::size_t i = 0; i < adjusted->points.size(); ++i) {
      const auto& [id, position] = adjusted->points[i];
      if (options.datum.ties.contains(id)) continue;
      points.add(truth.points.at(id).position_in_world - position - motion(position) * whole,
                 variance * adjusted->point_covariance[i]);
    }
    poses.end_block();
    points.end_block();
  }
  poses.expect_one("poses");
  points.expect_one("tie points");
}

// Control points by name: what they do together has no variance, G' C G = 0 over them, and of all points it is they
// whose covariance has the least trace. Sigmas of the camera are the same in every datum.
TEST(FreeNetwork, ChosenControlCarriesTheDatum) {
  const Block block = measured(free_block(3), 3);
  ExamineOptions options = exactly();
  options.adjust.calibration = Calibration::kFocal;
  const auto by_ties = examine(block, {}, options, kRun);
  const auto chosen = datum_points_named(block, "gcp0, gcp1,gcp3,gcp4");
  ASSERT_TRUE(chosen);
  ASSERT_EQ(chosen->control.size(), 4u);
  options.datum = *chosen;
  const auto by_control = examine(block, {}, options, kRun);
  ASSERT_TRUE(by_ties && by_control);
  double trace_by_ties = 0, trace_by_control = 0;
  for (std::size_t i = 0; i < by_ties->control.size(); ++i) {
    if (!options.datum.control.contains(by_ties->control[i].point)) continue;
    trace_by_ties += by_ties->control[i].covariance_m2->trace();
    trace_by_control += by_control->control[i].covariance_m2->trace();
  }
  EXPECT_LT(trace_by_control, 0.9 * trace_by_ties);
  EXPECT_NEAR(by_control->camera_covariance.begin()->second(Camera::kF, Camera::kF) /
                  by_ties->camera_covariance.begin()->second(Camera::kF, Camera::kF),
              1, 1e-6);
  EXPECT_EQ(by_control->sigma0, by_ties->sigma0);
  const Eigen::Matrix3d one = *by_control->control[0].covariance_m2;
  options.datum.control.clear();
  for (const auto& [id, point] : block.points) options.datum.ties.insert(id);  // by name, what is chosen by default
  const auto by_all = examine(block, {}, options, kRun);
  ASSERT_TRUE(by_all);
  EXPECT_NEAR(by_all->point_covariance[5].trace() / by_ties->point_covariance[5].trace(), 1, 1e-9);
  EXPECT_GT((one - *by_all->control[0].covariance_m2).norm(), 0.01 * one.norm());
}

TEST(FreeNetwork, ChosenPointsThatDoNotTellTheDatumAreRefused) {
  const Block block = measured(free_block(3), 3);
  ExamineOptions options = exactly();
  options.datum = datum_points_named(block, "gcp0,gcp1").value();
  const auto refused = examine(block, {}, options, kRun);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, Errc::kIllPosed);
  const auto nobody = datum_points_named(block, "gcp0, nobody");
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().code, Errc::kBadInput);
  EXPECT_NE(nobody.error().message.find("\"nobody\""), std::string::npos);
  const auto slip = datum_points_named(block, "GCP1");
  ASSERT_FALSE(slip);
  EXPECT_NE(slip.error().message.find("did you mean gcp1"), std::string::npos) << slip.error().message;
  EXPECT_EQ(slip.error().options, std::vector{"datum_points"_option});
  EXPECT_EQ(datum_points_named(block, "102, gcp4").value().ties, std::set{PointId{102}});
}

// Where control fixes the block there is nothing to choose.
TEST(FreeNetwork, ACompleteDatumStaysAsItIs) {
  const Block block = measured(test_block({.rows = 2, .columns = 3, .points = 40, .control = 9}), 3);
  ExamineOptions options = exactly();
  const auto usual = examine(block, {}, options, kRun);
  options.datum = datum_points_named(block, "gcp0,gcp1").value();
  const auto same = examine(block, {}, options, kRun);
  ASSERT_TRUE(usual && same);
  EXPECT_EQ(usual->pose_covariance, same->pose_covariance);
}

// Two tie points do not tell a turn about their line: the control points join them, and nothing is undefined.
TEST(FreeNetwork, TooFewTiePointsAreJoinedByControl) {
  for (const std::size_t kept : {std::size_t{2}, std::size_t{0}}) {
    Block block = test_block({.rows = 2, .columns = 3, .points = 40, .control = 60});
    for (auto& [id, control] : block.control) {
      control.role = ControlRole::kControl;
      control.sigma_m.setConstant(kInfinity);
    }
    while (block.points.size() > kept) block.points.erase(std::prev(block.points.end()));
    std::erase_if(block.observations, [&](const Observation& seen) { return !block.points.contains(seen.point); });
    const auto adjusted = examine(measured(block, 3), {}, exactly(), kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    EXPECT_EQ(adjusted->rank_defect, 7);
    double trace = 0;
    for (const auto& [id, covariance] : adjusted->pose_covariance) {
      EXPECT_TRUE(covariance.allFinite());
      EXPECT_GT(covariance.diagonal().minCoeff(), 0);
      EXPECT_LT(covariance.diagonal().tail<3>().maxCoeff(), 1);  // [m^2] of 60 m height
    }
    for (const ControlDifference& one : adjusted->control) trace += one.covariance_m2->trace();
    EXPECT_TRUE(std::isfinite(trace));
    EXPECT_GT(trace, 0);
  }
}

// A tie point more or less in the sum is all the difference between the datums of 40 and of 39 points; a check point
// where a tie point is has nearly the covariance of that one.
TEST(FreeNetwork, ACheckPointIsInTheDatumOfItsNeighbours) {
  const Block truth = free_block(2);
  Block block = measured(truth, 2);
  const PointId twin = block.points.begin()->first;
  const ControlId check{99};
  block.control[check] = {"twin", ControlRole::kCheck, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                          Eigen::Vector3d::Constant(0.01)};
  for (const Observation& seen : block.observations)
    if (seen.point == twin) block.control_observations.push_back({check, seen.image, seen.pixel, seen.sigma_px});
  const auto adjusted = examine(block, {}, exactly(), kRun);
  ASSERT_TRUE(adjusted && !adjusted->undetermined);
  ASSERT_EQ(adjusted->points.front().first, twin);
  for (const ControlDifference& one : adjusted->control)
    if (one.point == check) {
      const Eigen::Matrix3d &as_tie = adjusted->point_covariance.front(), &as_check = *one.covariance_m2;
      EXPECT_GT(as_check.trace(), as_tie.trace());  // its rays count twice otherwise
      EXPECT_LT(as_check.trace(), 1.5 * as_tie.trace());
    }
}

}  // namespace
}  // namespace collinea
