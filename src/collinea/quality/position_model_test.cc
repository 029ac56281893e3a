// SPDX-License-Identifier: Apache-2.0
// Antennas with lever arm, shift and drift; attitudes with boresight.
#include <gtest/gtest.h>

#include <cmath>

#include "collinea/adjust/gather.h"
#include "collinea/adjust/observation_kinds.h"
#include "collinea/block/subject_label.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/variance_components.h"

namespace collinea {
namespace {

using testing::normal3;
using testing::test_block;
using testing::tested;

const Run kRun;
const Eigen::Vector3d kUnknown = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
const Eigen::Vector3d kArm(0.3, -0.2, -0.5), kShift(0.4, -0.7, 1.1), kDrift(0.03, -0.02, 0.05),
    kRotation(0.02, -0.015, 0.03);
constexpr double kOffset_s = 0.13;

/// A block with control, and what its instruments say: antenna and attitudes with the errors above. The strips are
/// flown there and back, at 10 m/s give and take a tenth.
struct Flight {
  Block block;
  AdjustScope scope;
  Block truth;
};

Flight flight(double sigma_px, double sigma_m, double sigma_rad, std::uint64_t seed = 1, bool tracks = true) {
  Flight made{test_block({.sigma_px = sigma_px, .control = 9, .control_sigma_m = 0.01, .seed = seed}), {}, {}};
  made.truth = made.block;
  Random random(seed, 31);
  PositionTrack track;
  track.shift_sigma_m = track.drift_sigma_m = kUnknown;
  double time = -6;
  for (auto& [id, image] : made.block.images) {
    const Rigid3& pose = pose_of(made.block, id);
    const Eigen::Vector3d offset = tracks ? Eigen::Vector3d(kShift + time * kDrift) : Eigen::Vector3d(0, 0, 0);
    const int row = static_cast<int>(id.value - 10) / 4;
    const Eigen::Vector3d velocity = Eigen::Vector3d(row % 2 ? -10 : 10, 0, 0) + normal3(random);
    made.scope.velocity_m_s[id] = velocity;
    image.position = PositionPrior{
        centre_of(pose) + pose.rotation.conjugate() * kArm + offset + kOffset_s * velocity + sigma_m * normal3(random),
        Eigen::Vector3d::Constant(sigma_m > 0 ? sigma_m : 0.01)};
    // cam_from_world = turn * given; errors are turns in the world.
    made.scope.attitudes[id] = {
        (rotation_by(kRotation).conjugate() * pose.rotation * rotation_by(sigma_rad * normal3(random))).normalized(),
        Eigen::Vector3d::Constant(sigma_rad > 0 ? sigma_rad : 0.001)};
    track.time[id] = time++;
  }
  made.scope.lever_arms[{1}] = {Eigen::Vector3d::Zero(), kUnknown};
  made.scope.boresight_sigma_rad[{1}] = kUnknown;
  made.scope.time_offset_sigma_s[{1}] = kUnknown[0];
  if (tracks) made.scope.position_tracks = {track};
  return made;
}

Eigen::Vector3d truth_of(UnknownKind kind) {
  return kind == UnknownKind::kTimeOffset ? Eigen::Vector3d(kOffset_s, 0, 0)
         : kind == UnknownKind::kLeverArm ? kArm
         : kind == UnknownKind::kShift    ? kShift
         : kind == UnknownKind::kDrift    ? kDrift
                                          : kRotation;
}

TEST(PositionModel, DerivativesAreThoseOfDifferences) {
  const Flight made = flight(0, 0, 0.02);
  auto gathered = bundle::gather(made.block, made.scope, tested().adjust);
  ASSERT_TRUE(gathered) << gathered.error().message;
  const bundle::Problem& problem = gathered->problem;
  bundle::State& state = gathered->start;
  Random random(3);
  for (double& value : state.auxiliaries) value = 0.1 * random.normal();
  const auto moved = [&](int row, double by) {
    bundle::State next = state;
    if (row >= 6 * problem.poses) {
      next.auxiliaries[static_cast<std::size_t>(row - 6 * problem.poses - problem.first_auxiliary)] += by;
      return next;
    }
    const auto image = static_cast<std::size_t>(row / 6);
    Eigen::Vector3d centre(state.frames[image].data() + 9);
    if (row % 6 < 3)
      next.rotations[image] = rotation_by(by * Eigen::Vector3d::Unit(row % 6)) * state.rotations[image];
    else
      centre[row % 6 - 3] += by;
    next.frames[image] = bundle::frame_of(next.rotations[image], centre.data());
    return next;
  };
  constexpr double kStep = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    for (const bundle::GivenPosition& position : problem.positions)
      for (const bundle::RowPart& part : row_of(problem, state, position, axis)) {
        const double slope =
            (antenna_of(moved(part.row, kStep), position) - antenna_of(moved(part.row, -kStep), position))[axis] /
            (2 * kStep);
        EXPECT_NEAR(slope, part.derivative, 1e-7);
      }
    // To the first order of the residual (0.2 rad) and the third of the boresight.
    for (const bundle::GivenRotation& given : problem.attitudes)
      for (const bundle::RowPart& part : row_of(problem, state, given, axis)) {
        const double slope =
            -(residual_of(moved(part.row, kStep), given) - residual_of(moved(part.row, -kStep), given))[axis] /
            (2 * kStep);
        EXPECT_NEAR(slope, part.derivative, 0.01);
      }
  }
}

TEST(PositionModel, ExactTruthComesBack) {
  const Flight made = flight(0, 0, 0);
  Block start = testing::disturbed(made.block, 0.005, 0.3);
  const auto adjusted = examine(start, made.scope, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_TRUE(adjusted->converged);
  EXPECT_EQ(adjusted->rank_defect, 0);
  ASSERT_EQ(adjusted->auxiliaries.size(), 13u);
  for (const EstimatedUnknown& auxiliary : adjusted->auxiliaries)
    EXPECT_NEAR(auxiliary.value, truth_of(auxiliary.kind)[auxiliary.axis], 1e-6)
        << label_of(subject_of(auxiliary.kind, 1, auxiliary.axis), start);
  for (const auto& [id, pose] : adjusted->cam_from_world)
    EXPECT_LT((centre_of(pose) - centre_of(pose_of(made.truth, id))).norm(), 1e-6);
  EXPECT_NEAR(adjusted->reliability->redundancy_sum, double(adjusted->redundancy), 1e-4);
}

// Every unknown over its sigma is a standard normal variable: 80 blocks, of each kind three axes that are nearly
// independent. Four deviations of the mean of squares, and no single one beyond 4.5 (one of 150,000).
TEST(PositionModel, ErrorsAreAsLargeAsTheirSigmas) {
  std::map<UnknownKind, double> squares;
  constexpr int kBlocks = 80;
  ExamineOptions options = tested(Calibration::kFocal);
  options.test.sigma0_known = true;
  for (int i = 0; i < kBlocks; ++i) {
    Flight made = flight(0.5, 0.03, 0.003, static_cast<std::uint64_t>(i + 1));
    Random random(static_cast<std::uint64_t>(i), 8);
    made.scope.first_cameras = made.block.cameras;
    made.scope.first_cameras.begin()->second.params[Camera::kF] += 50 * random.normal();
    const auto adjusted = examine(made.block, made.scope, options, kRun);
    ASSERT_TRUE(adjusted && !adjusted->undetermined);
    for (const EstimatedUnknown& auxiliary : adjusted->auxiliaries) {
      const double ratio = (auxiliary.value - truth_of(auxiliary.kind)[auxiliary.axis]) / auxiliary.sigma;
      EXPECT_LT(std::abs(ratio), 4.5) << label_of(subject_of(auxiliary.kind, 1, auxiliary.axis), made.block);
      squares[auxiliary.kind] += ratio * ratio / (auxiliary.kind == UnknownKind::kTimeOffset ? 1 : 3);
    }
  }
  EXPECT_EQ(squares.size(), 5u);
  for (const auto& [kind, sum] : squares)
    EXPECT_NEAR(sum / kBlocks, 1, 4 * std::sqrt(2.0 / kBlocks)) << static_cast<int>(kind);
}

// An arm that is known is removed, whatever its size.
TEST(PositionModel, AGivenLeverArmIsUsed) {
  Flight made = flight(0, 0, 0, 1, false);
  made.scope.lever_arms[{1}] = {kArm, Eigen::Vector3d::Zero()};
  made.scope.use_control = false;
  const auto adjusted = examine(made.block, made.scope, tested(), kRun);
  ASSERT_TRUE(adjusted);
  for (const auto& [id, pose] : adjusted->cam_from_world)
    EXPECT_LT((centre_of(pose) - centre_of(pose_of(made.truth, id))).norm(), 1e-6);
  EXPECT_EQ(adjusted->auxiliaries.size(), 4u);  // boresight and time offset
}

TEST(PositionModel, AShiftOfAllPositionsLeavesTheBlockMovable) {
  Flight made = flight(0, 0, 0, 1);
  made.scope.use_control = false;
  made.scope.lever_arms.clear();
  made.scope.attitudes.clear();
  made.scope.position_tracks[0].drift_sigma_m.setZero();
  const auto adjusted = examine(made.block, made.scope, tested(), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  EXPECT_EQ(adjusted->rank_defect, 3);
}

// One height over flat ground, nothing known of f: it and the arm along the axis move the antennas alike.
TEST(PositionModel, TheArmAlongTheAxisAndTheFocalLengthAreNamedAsInseparable) {
  Flight made{
      test_block({.height_m = 600, .spacing_m = 150, .relief_m = 0, .sigma_px = 0.5, .control = 9, .tilt_rad = 0.005}),
      {},
      {}};
  for (auto& [id, image] : made.block.images)
    image.position = PositionPrior{centre_of(pose_of(made.block, id)), Eigen::Vector3d::Constant(0.05)};
  made.block.cameras.begin()->second.prior.sigma_f_px = 1e4;
  made.scope.lever_arms[{1}] = {Eigen::Vector3d::Zero(), kUnknown};
  const auto adjusted = examine(made.block, made.scope, tested(Calibration::kFocal), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  std::string reported = label_of(adjusted->undetermined, made.block);
  for (const Finding& pair : adjusted->inseparable) reported += label_of(pair, made.block) + "\n";
  EXPECT_NE(reported.find("inseparable: lever_arm of camera test, f of camera test; correlation"), std::string::npos)
      << reported;
  const Flight well = flight(0.5, 0.03, 0.003);
  const auto separable = examine(well.block, well.scope, tested(Calibration::kFocal), kRun);
  ASSERT_TRUE(separable);
  EXPECT_TRUE(separable->inseparable.empty()) << label_of(separable->inseparable[0], well.block);
}

// One way over the country, diagonally: what the clock is late looks like a shift along the flight.
TEST(PositionModel, ATimeOffsetAndAShiftOfOneFlightDirectionAreNamedAsInseparable) {
  Flight made = flight(0.5, 0.03, 0.003);
  Random random(5);
  for (auto& [id, velocity] : made.scope.velocity_m_s) {
    velocity = Eigen::Vector3d(7, 7, 0) + 0.05 * normal3(random);
    made.block.images.at(id).position->position_in_world =
        centre_of(pose_of(made.truth, id)) + kOffset_s * velocity + 0.03 * normal3(random);
  }
  made.scope.lever_arms.clear();
  made.scope.position_tracks[0].drift_sigma_m.setZero();
  const auto adjusted = examine(made.block, made.scope, tested(Calibration::kFocal), kRun);
  ASSERT_TRUE(adjusted) << adjusted.error().message;
  ASSERT_EQ(adjusted->inseparable.size(), 1u);
  const Finding& pair = adjusted->inseparable[0];
  EXPECT_EQ(label_of(pair.subjects[0], made.block), "time_offset of camera test");
  EXPECT_EQ(pair.subjects[1].kind, SubjectKind::kStrip);
  EXPECT_EQ(pair.subjects[1].aspect, Aspect::kShift);
  EXPECT_EQ(pair.subjects[1].axis, Subject::kAlongFlight);
  EXPECT_EQ(pair.subjects[1].id, 0u);
  EXPECT_GT(pair.figure(FigureName::kCorrelation).value_or(0), 0.99);
  EXPECT_FALSE(pair.remedies.empty());
  for (auto& [id, velocity] : made.scope.velocity_m_s) velocity = {7, 7, 0};  // then nothing tells them apart
  const auto singular = examine(made.block, made.scope, tested(Calibration::kFocal), kRun);
  ASSERT_TRUE(singular);
  ASSERT_TRUE(singular->undetermined);
  EXPECT_EQ(label_of(singular->undetermined->subjects[0], made.block), "time_offset of camera test");
}

TEST(PositionModel, ATimeOffsetThatIsKnownToBeSmallHolds) {
  Flight made = flight(0.5, 0.03, 0.003);
  made.scope.time_offset_sigma_s[{1}] = 1e-6;
  const auto adjusted = examine(made.block, made.scope, tested(), kRun);
  ASSERT_TRUE(adjusted);
  for (const EstimatedUnknown& auxiliary : adjusted->auxiliaries)
    if (auxiliary.kind == UnknownKind::kTimeOffset) {
      EXPECT_NEAR(auxiliary.value, 0, 1e-4);
    }
  made.scope.time_offset_sigma_s[{1}] = 0;  // there is none
  const auto without = examine(made.block, made.scope, tested(), kRun);
  ASSERT_TRUE(without);
  EXPECT_EQ(without->auxiliaries.size() + 1, adjusted->auxiliaries.size());
}

TEST(PositionModel, AGrossErrorInAnAttitudeIsFound) {
  Flight made = flight(0.5, 0.03, 0.001);
  auto& wrong = made.scope.attitudes.at({15});
  wrong.cam_from_world = wrong.cam_from_world * rotation_by({0, 0, 0.02});
  const auto adjusted = examine(made.block, made.scope, tested(Calibration::kFocal), kRun);
  ASSERT_TRUE(adjusted && adjusted->reliability && !adjusted->reliability->suspects.empty());
  const TestedObservation& worst = adjusted->reliability->suspects[0];
  EXPECT_EQ(worst.group, ObservationGroup::kAttitudeHeading);
  EXPECT_EQ(worst.source, 15u);
  EXPECT_NEAR(std::abs(worst.gross_error), 0.02, 0.005);
}

TEST(PositionModel, VarianceComponentsFindTheSigmasOfAttitudes) {
  Flight made = flight(0.5, 0.03, 0.003);
  for (auto& [id, attitude] : made.scope.attitudes) attitude.sigma_rad /= 3;
  const auto found = estimate_variance_components(made.block, made.scope, tested(), kRun);
  ASSERT_TRUE(found) << found.error().message;
  const auto group = static_cast<std::size_t>(ObservationGroup::kAttitudeLevel);
  EXPECT_NEAR(found->factors[group], 3, 4 * found->sigma[group]);
}

TEST(PositionModel, WhatCannotBeIsRefused) {
  Flight made = flight(0, 0, 0);
  made.scope.lever_arms[{1}].sigma_m = {0, 1, 1};
  EXPECT_EQ(examine(made.block, made.scope, tested(), kRun).error().code, Errc::kBadInput);
  made = flight(0, 0, 0);
  made.scope.attitudes.begin()->second.sigma_rad.x() = 0;
  EXPECT_EQ(examine(made.block, made.scope, tested(), kRun).error().code, Errc::kBadInput);
  made = flight(0, 0, 0);
  made.scope.position_tracks[0].time.begin()->second = std::nan("");
  EXPECT_EQ(examine(made.block, made.scope, tested(), kRun).error().code, Errc::kBadInput);
  made = flight(0, 0, 0);
  made.scope.time_offset_sigma_s[{1}] = -1;
  EXPECT_EQ(examine(made.block, made.scope, tested(), kRun).error().code, Errc::kBadInput);
  made = flight(0, 0, 0);
  made.scope.velocity_m_s.begin()->second.x() = std::nan("");
  EXPECT_EQ(examine(made.block, made.scope, tested(), kRun).error().code, Errc::kBadInput);
}

}  // namespace
}  // namespace collinea
