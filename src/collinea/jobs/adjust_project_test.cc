// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/adjust_project.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "collinea/base/test_folder.h"
#include "collinea/steps/flow.h"
#include "collinea/steps/test_project.h"

namespace collinea {
namespace {

TEST(AdjustProject, ATrialWritesReportAndTablesAndLeavesTheProjectAsItIs) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project) << project.error().message;
  const std::filesystem::path out = folder / "trial";
  const auto early = try_adjustment(*project, {}, out);
  ASSERT_FALSE(early);
  EXPECT_EQ(early.error().code, Errc::kNotFound);
  ASSERT_TRUE(bring_up_to(*project, Step::kOrient));
  const Block before = *project->store.read_block();

  for (const bool components : {false, true}) {
    const auto done = try_adjustment(*project, {.variance_components = components}, out);
    ASSERT_TRUE(done) << done.error().message;
    const nlohmann::json report = report_in(out);
    EXPECT_EQ(report.at("sigma0").get<double>(), done->adjusted.sigma0);
    // Orientation left sigmas as the residuals show them: sigma0 is 1 within four of its standard deviations
    // (chi-squared with the redundancy); variance components are repeated until 1 %.
    const double bound = components ? 0.01 : 4 / std::sqrt(2 * report.at("redundancy").get<double>());
    EXPECT_NEAR(report.at("sigma0").get<double>(), 1, bound);
    EXPECT_LT(bound, 0.1);
    EXPECT_FALSE(report.at("control_points").empty());
    EXPECT_TRUE(report.at("control_points").at(0).at("sigma_m").at(2).is_number());
    EXPECT_FALSE(report.at("reliability").at("groups").empty());
    EXPECT_EQ(report.at("reliability").at("groups").at(0).contains("applied_factor"), components);
  }
  for (const char* name :
       {"poses.csv", "cameras.csv", "points.csv", "control.csv", "observations.csv", "suspects.csv", "adjustment.html"})
    EXPECT_GT(std::filesystem::file_size(out / name), 20u) << name;
  const Block after = *project->store.read_block();
  EXPECT_FALSE(project->store.read_step("adjust")->has_value());
  EXPECT_FALSE(std::filesystem::exists(folder / "block" / "adjustment"));
  for (const auto& [id, pose] : oriented_images(before)) EXPECT_EQ(pose.translation, pose_of(after, id).translation);
}

// Gross errors in the oriented block of a project: they are rejected, reported, and do not spoil what is written.
TEST(AdjustProject, SnoopingTakesOutWhatIsWrongInAProject) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const auto report_of = [&](bool snoop) {
    const auto done =
        try_adjustment(*project, {.loss = Loss::kNone, .reject_mismatches = false, .snoop = snoop}, folder / "trial");
    EXPECT_TRUE(done) << done.error().message;
    return report_in(folder / "trial");
  };
  const double sigma0 = report_of(true).at("sigma0").get<double>();
  Block block = *project->store.read_block();
  std::map<PointId, int> rays;
  for (const Observation& seen : block.observations) ++rays[seen.point];
  std::vector<std::string> wrong;
  std::set<PointId> points;
  for (std::size_t i = 50; i < block.observations.size() && wrong.size() < 5; i += 20) {
    Observation& seen = block.observations[i];
    // Of two rays neither is known to be wrong, and along its base nothing checks the other of three.
    if (rays[seen.point] < 4 || !points.insert(seen.point).second) continue;
    seen.pixel.x() += 40 * seen.sigma_px;
    wrong.push_back("tie point " + std::to_string(seen.point.value) + " in " + block.images.at(seen.image).file);
  }
  ASSERT_EQ(wrong.size(), 5u);
  ASSERT_TRUE(project->store.write_orientation(block));
  EXPECT_FALSE(report_of(false).contains("snooping"));
  EXPECT_FALSE(std::filesystem::exists(folder / "trial" / "rejected.csv"));
  const nlohmann::json report = report_of(true);
  EXPECT_NEAR(report.at("sigma0").get<double>(), sigma0, 0.02 * sigma0);
  const nlohmann::json& snooping = report.at("snooping");
  EXPECT_TRUE(snooping.at("finished").get<bool>());
  EXPECT_GT(snooping.at("sigma0_before").get<double>(), 1.05 * sigma0);
  std::ifstream file(folder / "trial" / "rejected.csv");
  const std::string table{std::istreambuf_iterator<char>(file), {}};
  for (const std::string& name : wrong) {
    EXPECT_NE(table.find(name), std::string::npos) << name;
    bool reported = false;
    for (const auto& rejected : snooping.at("rejected")) reported |= rejected.at("observation") == name;
    EXPECT_TRUE(reported) << name;
  }
}

// Poses, cameras and points of the project are those of the step, whatever was adjusted before.
TEST(AdjustStep, IsTheProjectsAndBeginsWhereOrientationEnded) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const Block found = *project->store.read_block();
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  const auto record = project->store.read_outcome<AdjustmentRecord>();
  ASSERT_TRUE(record) << record.error().message;
  EXPECT_EQ(record->images, count_oriented(found));
  EXPECT_GT(record->redundancy, 0);
  EXPECT_TRUE(record->control_rmse_m && record->position_rms_m);
  EXPECT_EQ(report_in(folder / "block" / "adjustment").at("sigma0").get<double>(), record->sigma0);
  const Block adjusted = *project->store.read_block();
  const ImageId image = oriented_images(found).front().image;
  EXPECT_NE(pose_of(found, image).translation, pose_of(adjusted, image).translation);
  const auto covariances = project->store.read_covariances();
  ASSERT_TRUE(covariances);
  EXPECT_EQ(covariances->poses.size(), count_oriented(adjusted));
  EXPECT_EQ(covariances->points.size(), adjusted.points.size());

  project->settings.adjust.use_control = false;
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  EXPECT_FALSE(project->store.read_outcome<AdjustmentRecord>()->control_rmse_m);
  EXPECT_NE(pose_of(*project->store.read_block(), image).translation, pose_of(adjusted, image).translation);
  EXPECT_EQ(pose_of(*project->store.read_found(), image).translation, pose_of(found, image).translation);
  project->settings.adjust.use_control = true;
  ASSERT_TRUE(bring_up_to(*project, Step::kAdjust));
  EXPECT_EQ(pose_of(*project->store.read_block(), image).translation, pose_of(adjusted, image).translation);
}

TEST(AdjustProject, RaysOfCheckPointsTakePartOrNotAndBothAreReported) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const auto adjusted = [&](std::optional<bool> rays) {
    return try_adjustment(*project, {.check_rays = rays, .snoop = false, .systematics = Systematics::kNone},
                          folder / "trial");
  };
  const auto plain = adjusted(std::nullopt), with = adjusted(true);
  const nlohmann::json report = report_in(folder / "trial");
  const auto without = adjusted(false);
  ASSERT_TRUE(plain && with && without);
  EXPECT_FALSE(plain->other_check_rays);
  EXPECT_EQ(plain->adjusted.sigma0, without->adjusted.sigma0);
  EXPECT_GT(with->adjusted.redundancy, without->adjusted.redundancy);
  ASSERT_TRUE(with->other_check_rays && without->other_check_rays);
  EXPECT_EQ(with->other_check_rays->redundancy, without->adjusted.redundancy);
  EXPECT_EQ(without->other_check_rays->redundancy, with->adjusted.redundancy);
  // The second adjustment ends where an adjustment of its own does.
  const auto compare = [](const OtherCheckRays& other, const Adjusted& own) {
    ASSERT_EQ(other.control.size(), own.control.size());
    for (std::size_t i = 0; i < own.control.size(); ++i) {
      const double sigma_m = own.control[i].difference_sigma_m.norm();
      EXPECT_LT((other.control[i].difference_m - own.control[i].difference_m).norm(), 0.01 * sigma_m);
      EXPECT_NEAR(other.control[i].difference_sigma_m.norm(), sigma_m, 1e-3 * sigma_m);
    }
  };
  compare(*with->other_check_rays, without->adjusted);
  compare(*without->other_check_rays, with->adjusted);
  const nlohmann::json& rays = report.at("accuracy").at("check_rays");
  EXPECT_TRUE(rays.at("take_part").get<bool>());
  EXPECT_EQ(rays.at("with").at("vertical").at("fit_rmse_m"), report.at("accuracy").at("vertical").at("fit_rmse_m"));
  EXPECT_NE(rays.at("without").at("vertical").at("fit_rmse_m"), rays.at("with").at("vertical").at("fit_rmse_m"));
  EXPECT_EQ(rays.at("with").at("points").size(), rays.at("without").at("points").size());
}

// Rows of tie_residuals.csv by their fields.
std::vector<std::vector<std::string>> residual_rows(const std::filesystem::path& folder) {
  std::ifstream file(folder / "tie_residuals.csv");
  std::vector<std::vector<std::string>> rows;
  for (std::string line; std::getline(file, line);) {
    std::vector<std::string> fields(1);
    for (const char c : line)
      if (c == ',')
        fields.emplace_back();
      else if (c != '"')
        fields.back() += c;
    rows.push_back(fields);
  }
  return rows;
}

// What nothing checks has no test.
double value_of(const std::string& field) { return field.empty() ? std::nan("") : std::stod(field); }

TEST(AdjustProject, ResidualsOfTiePointsAreATableOfAllMeasurements) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  Block block = *project->store.read_block();
  ASSERT_GT(block.observations.size(), 300u);
  std::map<PointId, int> seen;
  for (const Observation& one : block.observations) ++seen[one.point];
  std::size_t spoilt = 0;
  while (seen[block.observations[spoilt].point] < 5) ++spoilt;
  block.observations[spoilt].pixel.x() += 60 * block.observations[spoilt].sigma_px;
  ASSERT_TRUE(project->store.write_orientation(block));
  for (const bool snoop : {false, true}) {
    const auto done = try_adjustment(*project,
                                     {.loss = snoop ? Loss::kNone : Loss::kHuber,
                                      .snoop = snoop,
                                      .tie_residuals = true,
                                      .systematics = Systematics::kNone},
                                     folder / "trial");
    ASSERT_TRUE(done) << done.error().message;
    const auto rows = residual_rows(folder / "trial");
    ASSERT_EQ(rows.size(), block.observations.size() + 1);
    const std::vector<std::string> titles = rows.front();
    ASSERT_EQ(titles.size(), 14u);
    double redundancy = 0;
    std::size_t used = 0, rejected = 0;
    for (std::size_t i = 1; i < rows.size(); ++i) {
      const std::vector<std::string>& row = rows[i];
      ASSERT_EQ(row.size(), titles.size());
      const Observation& one = block.observations[i - 1];
      EXPECT_EQ(row[0], block.images.at(one.image).file);
      EXPECT_EQ(row[1], std::to_string(one.point.value));
      EXPECT_NEAR(value_of(row[2]), one.pixel.x(), 1e-4);
      rejected += row[13] == "gross_error";
      if (row[13] != "used" && row[13] != "suspected") continue;
      ++used;
      redundancy += value_of(row[7]) + value_of(row[8]);
      EXPECT_EQ(row[13] == "suspected",
                std::fmax(std::abs(value_of(row[9])), std::abs(value_of(row[10]))) > value_of(row[11]));
      if (done->adjusted.tie_loss.kind == Loss::kNone && !row[9].empty()) {
        const double sigma = done->adjusted.sigma0 * one.sigma_px * std::sqrt(value_of(row[7]));
        EXPECT_NEAR(value_of(row[9]), value_of(row[5]) / sigma, 1e-3 * (1 + std::abs(value_of(row[9]))));
        EXPECT_EQ(row[12], "1");
      }
    }
    EXPECT_EQ(used, done->adjusted.observations.size());
    const auto& group = done->adjusted.reliability->groups[static_cast<std::size_t>(ObservationGroup::kTieImages)];
    EXPECT_NEAR(redundancy, group.redundancy, 1e-4 * group.redundancy);
    // The tests are those of the report.
    for (const TestedObservation& suspect : done->adjusted.reliability->suspects)
      if (suspect.group == ObservationGroup::kTieImages && std::isfinite(suspect.w)) {
        const Observation& one = done->block.observations[suspect.source];
        bool found = false;
        for (const auto& row : rows)
          found |= row[1] == std::to_string(one.point.value) && row[0] == done->block.images.at(one.image).file &&
                   std::abs(value_of(row[std::size_t(9 + suspect.axis)]) - suspect.w) < 1e-4 * std::abs(suspect.w);
        EXPECT_TRUE(found);
      }
    const std::vector<std::string>& wrong = rows[spoilt + 1];
    EXPECT_EQ(wrong[13], snoop ? "gross_error" : "suspected");
    EXPECT_GT(std::abs(value_of(wrong[5])), 25 * block.observations[spoilt].sigma_px);
    if (snoop) {
      EXPECT_GE(rejected, 1u);
      EXPECT_EQ(wrong[12], "0");
      EXPECT_EQ(wrong[9], "");
    } else {
      EXPECT_LT(value_of(wrong[12]), 0.3);
    }
  }
  ASSERT_TRUE(try_adjustment(*project, {.systematics = Systematics::kNone}, folder / "trial"));
  EXPECT_FALSE(std::filesystem::exists(folder / "trial" / "tie_residuals.csv"));
}

TEST(AdjustProject, PointsOfTheDatumOfAFreeNetworkAreChosenByName) {
  const TestFolder folder;
  auto project = open_small_survey(folder / "block");
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  AdjustmentOptions asked{.use_positions = false,
                          .use_control = false,
                          .check_rays = true,
                          .snoop = false,
                          .systematics = Systematics::kNone};
  const auto free = try_adjustment(*project, asked, folder / "trial");
  ASSERT_TRUE(free) << free.error().message;
  ASSERT_EQ(free->adjusted.rank_defect, 7);
  std::vector<std::string> names;
  for (const ControlDifference& one : free->adjusted.control)
    if (one.covariance_m2) names.push_back(free->block.control.at(one.point).name);
  ASSERT_GE(names.size(), 4u);
  asked.datum_points = names[0] + ", " + names[1] + "," + names[2] + "," + names[3];
  const auto chosen = try_adjustment(*project, asked, folder / "trial");
  ASSERT_TRUE(chosen) << chosen.error().message;
  const nlohmann::json report = report_in(folder / "trial");
  EXPECT_EQ(report.at("datum_points").at("names").size(), 4u);
  EXPECT_TRUE(report.at("datum_points").at("have_effect").get<bool>());
  EXPECT_NEAR(chosen->adjusted.sigma0, free->adjusted.sigma0, 1e-9);
  // Of all datums that of these points has their least trace.
  double least = 0, by_ties = 0;
  for (std::size_t i = 0; i < chosen->adjusted.control.size(); ++i)
    if (chosen->datum_points.control.contains(chosen->adjusted.control[i].point)) {
      least += chosen->adjusted.control[i].covariance_m2->trace();
      by_ties += free->adjusted.control[i].covariance_m2->trace();
    }
  EXPECT_LT(least, by_ties);

  // Through a file too, which keeps the choice.
  ASSERT_TRUE(export_adjustment(*project, asked, folder / "block.txt"));
  const auto read = read_adjustment(folder / "block.txt");
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->options.datum_points, asked.datum_points);
  const auto again = adjust_file(*read, folder / "out", {});
  ASSERT_TRUE(again) << again.error().message;
  double once_more = 0;
  for (const ControlDifference& one : again->adjusted.control)
    if (again->datum_points.control.contains(one.point)) once_more += one.covariance_m2->trace();
  EXPECT_NEAR(once_more, least, 1e-5 * least);

  asked.check_rays.reset();
  const auto no_part = try_adjustment(*project, asked, folder / "trial");
  ASSERT_FALSE(no_part);
  EXPECT_EQ(no_part.error().code, Errc::kBadInput);
  EXPECT_EQ(no_part.error().options.back(), (OptionName{.name = "check_rays", .group = {}, .value = "yes"}));
  asked.datum_points = names[0] + "x";
  const auto nobody = try_adjustment(*project, asked, folder / "trial");
  ASSERT_FALSE(nobody);
  EXPECT_NE(nobody.error().message.find("did you mean " + names[0]), std::string::npos) << nobody.error().message;
  // A complete datum says that the choice has no effect.
  const auto fixed = try_adjustment(
      *project, {.datum_points = names[0], .snoop = false, .systematics = Systematics::kNone}, folder / "trial");
  ASSERT_TRUE(fixed) << fixed.error().message;
  EXPECT_FALSE(report_in(folder / "trial").at("datum_points").at("have_effect").get<bool>());
}

TEST(AdjustProject, RefusesOptionsOutOfRange) {
  const TestFolder folder;
  SurveyOptions survey;
  survey.images = 6;
  auto project = open_simulated(folder / "block", survey, {.points_per_image = 80});
  ASSERT_TRUE(project && bring_up_to(*project, Step::kOrient));
  const auto done = try_adjustment(*project, {.tests = {.folds = 1}}, folder / "trial");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Errc::kBadInput);
  EXPECT_EQ(done.error().options, std::vector{"folds"_option});
}

}  // namespace
}  // namespace collinea
