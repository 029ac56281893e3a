// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/control_check.h"
#include "collinea/block/transform.h"

#include <gtest/gtest.h>

#include <numbers>

#include "collinea/adjust/bundle.h"
#include "collinea/adjust/test_block.h"
#include "collinea/block/subject_label.h"

namespace collinea {
namespace {

using testing::test_block;

// A realistic block: noise, positions of 2 m, nine points. The frame is arbitrary: the check must not care.
Block block_with_control(int control = 9, bool own_frame = true, std::uint64_t seed = 1) {
  Block block =
      test_block({.rows = 3, .columns = 5, .sigma_px = 0.5, .position_sigma_m = 2, .control = control, .seed = seed});
  if (own_frame) transform(block, {0.1, rotation_by({1, 2, 0.4}), {5, 6, 7}});
  return block;
}

std::size_t index_of(const Block& block, ControlId id, int which) {
  for (std::size_t i = 0; i < block.control_observations.size(); ++i)
    if (block.control_observations[i].point == id && which-- == 0) return i;
  return block.control_observations.size();
}

TEST(CheckControl, GoodControlGivesNoFinding) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Block block = block_with_control(9, true, seed);
    const ControlDiagnosis diagnosis = check_control(block);
    for (const Finding& finding : diagnosis.findings) ADD_FAILURE() << seed << ": " << label_of(finding, block);
  }
}

TEST(CheckControl, NamesTheWrongMeasurementAndTheImage) {
  Block block = block_with_control();
  const ControlId id{4};
  const std::size_t index = index_of(block, id, 1);
  ASSERT_LT(index, block.control_observations.size());
  block.control_observations[index].pixel += Eigen::Vector2d(21, -28);
  const ControlDiagnosis diagnosis = check_control(block);
  ASSERT_EQ(diagnosis.findings.size(), 1u);
  const Finding& finding = diagnosis.findings.front();
  EXPECT_EQ(finding.code, FindingCode::kControlMeasurement);
  EXPECT_EQ(finding.subjects, (std::vector<Subject>{id, block.control_observations[index].image}));
  EXPECT_EQ(finding.severity, Severity::kWrong);
  EXPECT_NEAR(finding.figure(FigureName::kOffsetPx).value_or(0), 35, 4);
  EXPECT_EQ(diagnosis.excluded_observations, std::set<std::size_t>{index});
  EXPECT_TRUE(diagnosis.excluded_points.empty());
  Block mended = block;
  apply(diagnosis, mended);
  EXPECT_EQ(mended.control_observations.size() + 1, block.control_observations.size());
  EXPECT_TRUE(check_control(mended).findings.empty());
}

TEST(CheckControl, TwoRaysThatMissAreNotUsed) {
  Block block = block_with_control();
  const ControlId id{3};
  const ImageId first = block.control_observations[index_of(block, id, 0)].image;
  const ImageId second = block.control_observations[index_of(block, id, 3)].image;
  std::erase_if(block.control_observations,
                [&](const ControlObservation& o) { return o.point == id && o.image != first && o.image != second; });
  const Eigen::Vector3d base = centre_of(pose_of(block, first)) - centre_of(pose_of(block, second));
  const Eigen::Vector3d in_cam = pose_of(block, first).rotation * base;
  const Eigen::Vector2d across = Eigen::Vector2d(-in_cam.y(), in_cam.x()).normalized();
  block.control_observations[index_of(block, id, 0)].pixel += 90 * across;
  const ControlDiagnosis diagnosis = check_control(block);
  ASSERT_EQ(diagnosis.findings.size(), 1u);
  EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kControlMeasurementsDisagree);
  EXPECT_EQ(diagnosis.excluded_points, std::set<ControlId>{id});
}

TEST(CheckControl, APointAHundredMetresOffIsNamed) {
  for (const int count : {4, 5, 9}) {
    Block block = block_with_control(count);
    for (auto& [point, control] : block.control) control.role = ControlRole::kControl;
    const ControlId id{2};
    block.control.at(id).position_in_world.x() += 100;
    block.control.at(id).position_in_map.x() += 100;
    const ControlDiagnosis diagnosis = check_control(block);
    ASSERT_EQ(diagnosis.findings.size(), 1u) << count;
    EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kControlPoint);
    EXPECT_EQ(diagnosis.findings.front().subjects, std::vector<Subject>{id});
    EXPECT_NEAR(diagnosis.findings.front().figure(FigureName::kOffset).value_or(0), 100, 2);
    EXPECT_NEAR(diagnosis.findings.front().figure(FigureName::kOffsetPlan).value_or(0), 100, 2);
    EXPECT_LT(std::abs(diagnosis.findings.front().figure(FigureName::kOffsetHeight).value_or(100)), 20);
    EXPECT_EQ(diagnosis.excluded_points, std::set<ControlId>{id});
  }
}

TEST(CheckControl, ACheckPointFarOffIsNamedButDecidesNothing) {
  Block block = block_with_control(9);
  const ControlId id{2};
  ASSERT_EQ(block.control.at(id).role, ControlRole::kCheck);
  block.control.at(id).position_in_world.x() += 100;
  const ControlDiagnosis diagnosis = check_control(block);
  ASSERT_EQ(diagnosis.findings.size(), 1u);
  EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kCheckPoint);
  EXPECT_EQ(diagnosis.findings.front().subjects, std::vector<Subject>{id});
  EXPECT_TRUE(diagnosis.excluded_points.empty());
}

TEST(CheckControl, TwoBadPointsOfNineAreBothNamed) {
  Block block = block_with_control();
  block.control.at({1}).position_in_world += Eigen::Vector3d(0, 0, 5);
  block.control.at({7}).position_in_world += Eigen::Vector3d(-3, 30, 0);
  const ControlDiagnosis diagnosis = check_control(block);
  EXPECT_EQ(diagnosis.excluded_points, (std::set<ControlId>{{1}, {7}}));
  EXPECT_EQ(diagnosis.findings.size(), 2u);
}

TEST(CheckControl, OfThreePointsPositionsTellTheWrongOne) {
  Block block = block_with_control(3);
  for (auto& [point, control] : block.control) control.role = ControlRole::kControl;
  block.control.at({0}).position_in_world.y() -= 300;
  const ControlDiagnosis diagnosis = check_control(block);
  EXPECT_EQ(diagnosis.excluded_points, std::set<ControlId>{{0}});
}

void swap_map_axes(Block& block) {
  for (auto& [id, control] : block.control) {
    std::swap(control.position_in_map.x(), control.position_in_map.y());
    control.position_in_world = {4.5e6, -4.5e6, -3e6};  // wherever that is on Earth
    control.position_in_world += control.position_in_map * 1e-2;
  }
}

TEST(CheckControl, ExchangedAxesAreFoundInReliefAndOnFlatGround) {
  Block relief = block_with_control();
  swap_map_axes(relief);
  EXPECT_TRUE(check_control(relief).axes_swapped);
  Block flat = test_block({.relief_m = 0, .sigma_px = 0.5, .control = 6, .tilt_rad = 0.05});
  swap_map_axes(flat);
  const ControlDiagnosis diagnosis = check_control(flat);
  EXPECT_TRUE(diagnosis.axes_swapped);
  ASSERT_EQ(diagnosis.findings.size(), 1u);
  EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kControlAxesSwapped);
}

// Six cameras look 20 degrees down over flat ground, held upside down: the pixels are stored with the sky below.
TEST(CheckControl, ImagesStoredUpsideDownAreNotTakenForExchangedAxes) {
  Block block;
  block.cameras[{1}] = testing::test_camera();
  for (std::uint32_t i = 0; i < 9; ++i) {
    ControlPoint& point = block.control[{i}];
    point.name = "gcp" + std::to_string(i);
    point.position_in_world = Eigen::Vector3d(5.0 * (i % 3), 50 + 6.0 * (i / 3), 0);
    point.position_in_map = point.position_in_world + Eigen::Vector3d(500000, 5000000, 0);
    point.sigma_m.setConstant(0.01);
  }
  const double slope = 20 * std::numbers::pi / 180;
  Eigen::Matrix3d cam_from_world;
  cam_from_world << -1, 0, 0, 0, std::sin(slope), std::cos(slope), 0, std::cos(slope), -std::sin(slope);
  for (std::uint32_t i = 0; i < 6; ++i) {
    block.images[{i}].camera = {1};
    block.images[{i}].orientation = 3;
    set_pose(block, {i}, {Eigen::Quaterniond(cam_from_world), -(cam_from_world * Eigen::Vector3d(3.0 * i - 2, 0, 20))});
    for (const auto& [id, point] : block.control) {
      const auto pixel = project(block.cameras.at({1}), pose_of(block, {i}) * point.position_in_world);
      ASSERT_TRUE(pixel);
      block.control_observations.push_back({id, {i}, *pixel, 0.5});
    }
  }
  EXPECT_TRUE(check_control(block).findings.empty());
  swap_map_axes(block);
  EXPECT_TRUE(check_control(block).axes_swapped);
}

TEST(CheckControl, PositionHeightsOffByAConstantAreShifted) {
  for (const int count : {1, 2, 9}) {
    Block block = block_with_control(count);
    for (auto& [id, image] : block.images) image.position->position_in_world.z() -= 73.1;
    const ControlDiagnosis diagnosis = check_control(block);
    ASSERT_EQ(diagnosis.findings.size(), 1u) << count;
    EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kPositionHeights);
    EXPECT_NEAR(diagnosis.findings.front().figure(FigureName::kUp).value_or(0), -73.1, 3);
    EXPECT_NEAR(diagnosis.position_height_shift_m, 73.1, 3);  // positions of 2 m
    EXPECT_FALSE(diagnosis.positions_unusable);
    Block mended = block;
    apply(diagnosis, mended);
    EXPECT_TRUE(check_control(mended).findings.empty());
  }
}

TEST(CheckControl, KilometresApartIsAnotherCoordinateSystem) {
  Block block = block_with_control();
  for (auto& [id, control] : block.control) control.position_in_world += Eigen::Vector3d(2500, -800, 0);
  const ControlDiagnosis diagnosis = check_control(block);
  ASSERT_EQ(diagnosis.findings.size(), 1u);
  EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kPositionCrs);
  EXPECT_NEAR(diagnosis.findings.front().figure(FigureName::kOffset).value_or(0), 2625, 5);
  EXPECT_TRUE(diagnosis.positions_unusable);
}

TEST(CheckControl, PositionsWithoutHeightsAreComparedInPlanOnly) {
  Block block = block_with_control();
  for (auto& [id, image] : block.images) {
    image.position->position_in_world.z() = 5000;  // not given
    image.position->sigma_m.z() = std::numeric_limits<double>::infinity();
  }
  EXPECT_TRUE(check_control(block).findings.empty());
  for (auto& [id, image] : block.images) image.position->position_in_world.y() += 40;
  const ControlDiagnosis diagnosis = check_control(block);
  ASSERT_EQ(diagnosis.findings.size(), 1u);
  EXPECT_EQ(diagnosis.findings.front().code, FindingCode::kPositionOffset);
  EXPECT_NEAR(diagnosis.findings.front().figure(FigureName::kOffset).value_or(0), 40, 3);
  EXPECT_EQ(diagnosis.position_height_shift_m, 0);
}

TEST(CheckControl, NothingToCheckIsNoFinding) {
  EXPECT_TRUE(check_control(Block{}).findings.empty());
  Block block = block_with_control(0);
  EXPECT_TRUE(check_control(block).findings.empty());
}

// Marks in coarse pixels: points scatter by decimetres though they were surveyed to centimetres. Of 300 blocks with six
// good points one in which five agree by chance must not lose the sixth.
TEST(CheckControl, GoodPointsOfCoarseImagesStay) {
  int excluded = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    Block block =
        testing::test_block({.rows = 2, .columns = 3, .points = 3, .sigma_px = 4, .control = 9, .seed = seed});
    excluded += static_cast<int>(check_control(block).excluded_points.size());
  }
  EXPECT_EQ(excluded, 0);
}

}  // namespace
}  // namespace collinea
