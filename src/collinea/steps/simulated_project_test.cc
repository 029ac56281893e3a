// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/simulated_project.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/test_folder.h"
#include "collinea/quality/examine.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"
#include "collinea/store/sqlite.h"
#include "collinea/synthetic/write.h"

namespace collinea {
namespace {

// Without wrong matches, of which sigmas know nothing.
TEST(SimulatedProject, IsOrientedWithoutImages) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 20;
  survey.control_points = 4;
  std::vector<std::string> lines;
  collinea::Run run{.log = [&](std::string_view line) { lines.emplace_back(line); }};
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 120, .wrong_share = 0}, run);
  ASSERT_TRUE(project) << project.error().message;
  const auto done = bring_up_to(*project, Step::kOrient);
  ASSERT_TRUE(done) << done.error().message;
  for (const char* step : {"import", "detect", "match"}) {
    const auto up_to_date = [&](const std::string& line) {
      return line.starts_with(step) && line.find("up to date") != std::string::npos;
    };
    EXPECT_EQ(std::count_if(lines.begin(), lines.end(), up_to_date), 1) << step;
  }
  const Block block = *project->store.read_block();
  ASSERT_EQ(count_oriented(block), 20u);
  const auto truth = read_truth(folder / "block");
  const auto adjusted = examine(block, {}, {.adjust = {.calibration = Calibration::kBrown}}, {});
  ASSERT_TRUE(truth && adjusted);
  double squares = 0, variance_m2 = 0;
  for (const auto& [id, covariance] : adjusted->pose_covariance) {
    const Eigen::Vector3d error =
        centre_of(pose_of(block, id)) - centre_of(truth->cam_from_world.at(block.images.at(id).file));
    const Eigen::Array3d variance = std::pow(adjusted->sigma0, 2) * covariance.diagonal().tail<3>().array();
    squares += (error.array().square() / variance).mean() / 20;
    variance_m2 += variance.sum() / 20;
  }
  // Squares of errors over their variances have the mean 1. Were those of one axis all the same for all images, which
  // they nearly are where the block sways as a whole, the mean of three would have the variance 2/3: four deviations.
  EXPECT_LT(squares, 1 + 4 * std::sqrt(2.0 / 3));
  EXPECT_LT(std::sqrt(variance_m2), 0.5);  // a seventh of what a receiver is good to, 3.3 m
}

TEST(SimulatedProject, WhatAnotherVersionRecordedIsDoneAgain) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 8;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 120, .wrong_share = 0}, {});
  ASSERT_TRUE(project) << project.error().message;
  ASSERT_TRUE(bring_up_to(*project, Step::kOrient));
  auto database = sqlite::Database::open(folder / "block" / "block.db");
  ASSERT_TRUE(database);
  ASSERT_TRUE(database->execute("UPDATE step_records SET record = x'63' WHERE step = 'orient'"));
  EXPECT_EQ(project->store.read_step("orient").error().code, Errc::kUnsupported);
  const auto done = bring_up_to(*project, Step::kOrient);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(project->store.read_outcome<OrientationRecord>()->oriented, 8u);
  ASSERT_TRUE(database->execute("UPDATE step_records SET record = substr(record, 1, 20) WHERE step = 'orient'"));
  EXPECT_EQ(bring_up_to(*project, Step::kOrient).error().code, Errc::kBadFormat);
}

// What was free, and the sigmas of that, are those of the cameras that were calibrated.
TEST(SimulatedProject, KeepsWhichParametersWereFree) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 12;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 120, .wrong_share = 0}, {});
  ASSERT_TRUE(project) << project.error().message;
  const std::tuple<std::optional<Calibration>, Calibration, int> cases[] = {
      {Calibration::kNone, Calibration::kNone, 0},
      {Calibration::kFocal, Calibration::kFocal, 1},
      {std::nullopt, Calibration::kBrown, 8}};
  for (const auto& [asked, used, count] : cases) {
    project->settings.orient.calibration = asked;
    ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
    const CalibrationRecord record = project->store.read_outcome<AdjustmentRecord>()->calibration;
    EXPECT_EQ(record.parameters, used);
    ASSERT_EQ(record.free.size(), count > 0 ? 1u : 0u) << word_of(used);
    if (count == 0) continue;
    const auto& [camera, free] = *record.free.begin();
    EXPECT_EQ(int(free.size()), count) << word_of(used);
    for (const std::uint32_t param : free)
      EXPECT_GT(record.sigma.at(camera).at(param), 0) << word_of(used) << " " << param;
    const auto& sigma = record.sigma.at(camera);
    EXPECT_EQ(std::count_if(sigma.begin(), sigma.end(), [](double one) { return one > 0; }), count) << word_of(used);
  }
}

// A fisheye of 122 degrees from corner to corner, known at first as a lens without distortion and a focal length 5 %
// off: the errors of its camera are as large as its standard deviations say.
TEST(SimulatedProject, OfAFisheyeIsOriented) {
  for (const CameraModel& model : {CameraModel(Equidistant{}), CameraModel(KannalaBrandt{})}) {
    const TestFolder folder;
    SurveyOptions survey;
    survey.images = 16;
    survey.camera.camera_model = model;
    survey.camera.focal_px = 1200;
    auto project = open_simulated(folder / "block", survey, {.points_per_image = 150, .wrong_share = 0},
                                  collinea::Run{.threads = 2});
    ASSERT_TRUE(project) << project.error().message;
    const auto done = bring_up_to(*project, Step::kOrient);
    ASSERT_TRUE(done) << done.error().message;
    const Block block = *project->store.read_block();
    EXPECT_EQ(count_oriented(block), 16u);
    const auto truth = read_truth(folder / "block");
    const auto setup = project->store.read_setup();
    ASSERT_TRUE(setup);
    AdjustScope scope;
    scope.first_cameras = setup->cameras;
    const auto adjusted = examine(block, scope, {.adjust = {.calibration = Calibration::kBrown}}, {});
    ASSERT_TRUE(truth && adjusted);
    const Camera& found = block.cameras.begin()->second;
    EXPECT_TRUE(found.model == model) << name_of(model);
    const MatrixPd& covariance = adjusted->camera_covariance.begin()->second;
    for (const int k : params_of(found)) {
      const double sigma = adjusted->sigma0 * std::sqrt(covariance(k, k));
      if (!(sigma > 0)) continue;
      EXPECT_NEAR(found.params[std::size_t(k)], truth->camera.params[std::size_t(k)], 4.5 * sigma)
          << name_of(model) << " " << param_name(k);
    }
    EXPECT_NEAR(found.focal_px(), 1200, 3);  // 0.25 %; it began 60 px off
  }
}

}  // namespace
}  // namespace collinea
