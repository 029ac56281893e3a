// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/given.h"

#include <gtest/gtest.h>

#include "collinea/orient/internal/test_pairs.h"

namespace collinea {
namespace {

using testing::centre_rms_m;
using testing::kPixel_m;
using testing::Matched;
using testing::matched;
using testing::test_block;

Matched small(double position_sigma_m = 0) { return matched(testing::small_block(0.5, 0, position_sigma_m)); }

GivenOrientation truth_of(const Matched& input) {
  return {testing::poses_of(input.truth), input.truth.cameras, false, "elsewhere"};
}

Result<Orientation> take(const Matched& input, const GivenOrientation& given, bool refine = false) {
  OrientOptions options;
  options.refine_orientation = refine;
  return orient_as_given(input.setup, input.pairs, input.source(), given, options, {});
}

TEST(OrientAsGiven, PosesAndCamerasStayToTheBitAndPointsAreIntersected) {
  const Matched input = small();
  const auto found = take(input, truth_of(input));
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_EQ(count_oriented(found->block), 8u);
  for (const auto& [image, pose] : oriented_images(found->block)) {
    EXPECT_EQ(pose.rotation.coeffs(), pose_of(input.truth, image).rotation.coeffs());
    EXPECT_EQ(pose.translation, pose_of(input.truth, image).translation);
  }
  EXPECT_EQ(found->block.cameras.begin()->second.params, input.truth.cameras.begin()->second.params);
  EXPECT_GT(found->block.points.size(), 450u);
  EXPECT_NEAR(found->adjusted.sigma0, 1, 0.15);
  EXPECT_TRUE(found->findings.empty()) << word_of(found->findings.front().code);
  EXPECT_FALSE(found->georeferenced);
  EXPECT_EQ(found->gauge, (Gauge{.given_by = "elsewhere"}));
}

TEST(OrientAsGiven, ImagesThatAreNotGivenAreNamed) {
  const Matched input = small();
  GivenOrientation given = truth_of(input);
  const ImageId left_out = given.cam_from_world.begin()->first;
  given.cam_from_world.erase(left_out);
  const auto found = take(input, given);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(count_oriented(found->block), 7u);
  EXPECT_EQ(found->alone, std::vector{left_out});
}

TEST(OrientAsGiven, AnArbitraryFrameIsBroughtToTheMapAndOneThatIsTheMapStays) {
  Matched input = small(0.3);
  input.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  GivenOrientation given = truth_of(input);
  const auto stays = take(input, given);
  ASSERT_TRUE(stays) << stays.error().message;
  EXPECT_TRUE(stays->georeferenced);
  EXPECT_EQ(centre_rms_m(stays->block, input.truth, false), 0);
  const Similarity3 elsewhere{0.1, rotation_by({1, 2, -0.4}), {5, 6, 7}};
  for (auto& [image, pose] : given.cam_from_world) pose = moved(pose, elsewhere);
  const auto moved_home = take(input, given);
  ASSERT_TRUE(moved_home) << moved_home.error().message;
  EXPECT_TRUE(moved_home->georeferenced);
  EXPECT_LT(centre_rms_m(moved_home->block, input.truth, false), 3 * 0.3);
  EXPECT_LT(centre_rms_m(moved_home->block, input.truth, true), 1e-9);
}

// Control that the model was fitted to cannot verify it.
TEST(OrientAsGiven, ControlThatFixedTheFrameCountsAsUsedAndOnlyCheckPointsAreIndependent) {
  Matched input =
      matched(test_block({.rows = 2, .columns = 4, .points = 500, .sigma_px = 0.5, .control = 9, .seed = 3}));
  input.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  GivenOrientation given = truth_of(input);
  const auto used_in = [&] {
    const auto found = take(input, given);
    EXPECT_TRUE(found) << found.error().message;
    std::set<ControlId> used;
    for (const ControlDifference& control : found->adjusted.control)
      if (control.used) used.insert(control.point);
    return used;
  };
  EXPECT_TRUE(used_in().empty());  // it lies in the map already
  for (auto& [image, pose] : given.cam_from_world) pose = moved(pose, {0.1, rotation_by({1, 2, -0.4}), {5, 6, 7}});
  const std::set<ControlId> used = used_in();
  EXPECT_GE(used.size(), 5u);  // of six; one that lies at the edge of what errors make may be left out
  for (const ControlId id : used) EXPECT_EQ(input.setup.control.at(id).role, ControlRole::kControl);
}

TEST(OrientAsGiven, WithoutCamerasTheseAreCalibratedOnThePosesThatStay) {
  const Matched input = small();
  GivenOrientation given = truth_of(input);
  given.cameras.clear();
  const auto found = take(input, given);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_EQ(centre_rms_m(found->block, input.truth, false), 0);
  EXPECT_NEAR(found->block.cameras.begin()->second.focal_px(), input.truth.cameras.begin()->second.focal_px(), 1);
}

TEST(OrientAsGiven, RefiningMendsPosesThatAreALittleOff) {
  const Matched input = small();
  GivenOrientation given = truth_of(input);
  given.cam_from_world = testing::poses_of(testing::disturbed(input.truth, 0.0005, 0.03));
  const auto fixed = take(input, given), refined = take(input, given, true);
  ASSERT_TRUE(fixed) << fixed.error().message;
  ASSERT_TRUE(refined) << refined.error().message;
  EXPECT_LT(centre_rms_m(refined->block, input.truth, true), 2 * kPixel_m);
  EXPECT_GT(fixed->adjusted.sigma0, 1.1 * refined->adjusted.sigma0);
  EXPECT_EQ(fixed->scope.fixed_images.size(), count_oriented(fixed->block));
  EXPECT_TRUE(refined->scope.fixed_images.empty());
}

TEST(OrientAsGiven, PosesThatFitFewMatchesAreDoubted) {
  const Matched input = small();
  GivenOrientation given = truth_of(input);
  given.cam_from_world = testing::poses_of(testing::disturbed(input.truth, 0.01, 0.5));
  const auto found = take(input, given);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_FALSE(found->findings.empty());
  EXPECT_EQ(found->findings.front().code, FindingCode::kFewFitGiven);
  EXPECT_EQ(found->findings.front().subjects, std::vector{Subject::file("elsewhere")});
}

// One pose of eight is turned by a quarter of a right angle: nothing its image shows fits there.
TEST(OrientAsGiven, AnImageWhosePoseNothingFitsIsNotOriented) {
  Matched input =
      matched(test_block({.rows = 2, .columns = 4, .points = 500, .sigma_px = 0.5, .control = 9, .seed = 3}));
  input.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  GivenOrientation given = truth_of(input);
  const ImageId wrong{12};
  Rigid3& pose = given.cam_from_world.at(wrong);
  pose.rotation = rotation_by({0.4, 0, 0}) * pose.rotation;
  pose.translation = rotation_by({0.4, 0, 0}) * pose.translation;
  const auto refined = take(input, given, true);
  ASSERT_TRUE(refined) << refined.error().message;
  EXPECT_EQ(refined->alone, std::vector{wrong});
  EXPECT_EQ(count_oriented(refined->block), 7u);
  EXPECT_TRUE(refined->adjusted.images_left_out.empty());
  EXPECT_TRUE(refined->excluded_control.empty());
  ASSERT_EQ(refined->findings.size(), 1u);
  EXPECT_EQ(refined->findings[0], finding_of(FindingCode::kImagesAlone, {wrong}, {{FigureName::kCount, 1}}));
  const auto fixed = take(input, given);
  ASSERT_TRUE(fixed) << fixed.error().message;
  EXPECT_EQ(count_oriented(fixed->block), 8u);
  EXPECT_TRUE(std::any_of(fixed->findings.begin(), fixed->findings.end(), [&](const Finding& finding) {
    return finding.code == FindingCode::kLooseGiven && finding.subjects == std::vector<Subject>{wrong} &&
           finding.figure(FigureName::kCount) == 1;
  }));
}

TEST(OrientAsGiven, RefiningAStripLeavesItsTiltToTheAttitudes) {
  Block block = test_block(
      {.rows = 1, .columns = 10, .points = 600, .sigma_px = 0.5, .position_sigma_m = 3, .tilt_rad = 0, .seed = 4});
  for (auto& [id, image] : block.images) image.attitude = AttitudePrior{90, -90, 0};
  Matched input = matched(block);
  input.setup.georeference = Georeference{"EPSG:32633", 48, 15, 300};
  const auto found = take(input, truth_of(input), true);
  ASSERT_TRUE(found) << found.error().message;
  EXPECT_TRUE(found->georeferenced);
  for (const auto& [image, pose] : oriented_images(found->block))
    EXPECT_LT((pose.rotation.conjugate() * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 0.05)
        << image.value;
}

TEST(OrientAsGiven, NoPosesAndPosesOfSomethingElseAreErrorsInWords) {
  const Matched input = small();
  EXPECT_EQ(take(input, {.source = "nothing"}).error().code, Errc::kBadInput);
  GivenOrientation given = truth_of(input);
  for (auto& [image, pose] : given.cam_from_world) pose = {};
  const auto found = take(input, given);
  ASSERT_FALSE(found);
  EXPECT_EQ(found.error().code, Errc::kIllPosed);
  EXPECT_NE(found.error().message.find("elsewhere"), std::string::npos) << found.error().message;
}

}  // namespace
}  // namespace collinea
