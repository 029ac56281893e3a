// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/model_findings.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/models/test_models.h"

namespace collinea {
namespace {

using testing::test_models;
using testing::TestModels;
using testing::TestModelsOptions;

TestModelsOptions with_noise() { return {.sigma = 0.02, .control_sigma_m = 0.02}; }

ModelsReport joined(TestModels made) {
  ModelsReport report;
  report.models = std::move(made.models);
  report.control = std::move(made.control);
  auto block = join_models(report.models, report.control, {}, {});
  EXPECT_TRUE(block) << block.error().message;
  if (block) report.block = *std::move(block);
  report.findings = model_findings(report);
  return report;
}

std::vector<FindingCode> codes_of(const ModelsReport& report) {
  std::vector<FindingCode> codes;
  for (const Finding& finding : report.findings) codes.push_back(finding.code);
  return codes;
}

const Finding* found(const ModelsReport& report, FindingCode code) {
  const auto at = std::ranges::find(report.findings, code, &Finding::code);
  return at == report.findings.end() ? nullptr : &*at;
}

SurveyedPoint& named(std::vector<SurveyedPoint>& control, const std::string& name) {
  return *std::ranges::find(control, name, &SurveyedPoint::name);
}

// Keeps of a model the points of these names.
void keep(StereoModel& model, const std::vector<std::string>& names) {
  std::erase_if(model.points,
                [&](const NamedPoint& point) { return std::ranges::find(names, point.name) == names.end(); });
}

TEST(ModelFindings, OfAGoodBlockThereAreNone) {
  EXPECT_EQ(codes_of(joined(test_models(with_noise()))), std::vector<FindingCode>{});
}

TEST(ModelFindings, AModelThatSharesTooLittleIsLeftOut) {
  TestModels made = test_models(with_noise());
  keep(made.models.back(), {"P203", "S103_0"});
  const ModelsReport one = joined(std::move(made));
  const Finding* turns = found(one, FindingCode::kModelTurns);
  ASSERT_TRUE(turns);
  EXPECT_EQ(turns->subjects.front(), Subject::model("103"));
  EXPECT_EQ(turns->figure(FigureName::kCount), 1);
  TestModels apart = test_models(with_noise());
  keep(apart.models.back(), {"S103_0"});
  EXPECT_TRUE(found(joined(std::move(apart)), FindingCode::kModelNoPoint));
}

TEST(ModelFindings, AModelThatHangsByFewPointsIsWeak) {
  TestModels made = test_models(with_noise());
  keep(made.models.back(), {"P203", "P303", "P403", "P204", "S103_0"});
  const ModelsReport report = joined(std::move(made));
  const Finding* few = found(report, FindingCode::kModelFewPoints);
  ASSERT_TRUE(few);
  EXPECT_EQ(few->subjects.front(), Subject::model("103"));
  EXPECT_EQ(few->figure(FigureName::kCount), 4);
}

// Two models without projection centres share the points of one column: 1200 m long, some 60 m wide.
TEST(ModelFindings, PointsNearALineLetAModelTurn) {
  TestModelsOptions options = with_noise();
  options.strips = 1;
  options.models = 2;
  options.centres = false;
  TestModels made = test_models(options);
  made.control.clear();
  const ModelsReport report = joined(std::move(made));
  const Finding* line = found(report, FindingCode::kModelPointsOnLine);
  ASSERT_TRUE(line);
  EXPECT_EQ(line->figure(FigureName::kCount), 3);
  EXPECT_LT(*line->figure(FigureName::kRatio), 0.1);
}

TEST(ModelFindings, ControlThatContradictsIsNamed) {
  TestModels made = test_models(with_noise());
  const std::string name = made.control.front().name;
  made.control.front().position.x() += 1;
  const ModelsReport report = joined(std::move(made));
  const Finding* contradicts = found(report, FindingCode::kControlContradicts);
  ASSERT_TRUE(contradicts);
  EXPECT_EQ(contradicts->subjects.front().kind, SubjectKind::kControlPoint);
  EXPECT_EQ(contradicts->subjects.front().name, name);
  EXPECT_EQ(contradicts->subjects.front().axis, 0);  // X
  EXPECT_TRUE(found(report, FindingCode::kResidualsLarge));
}

TEST(ModelFindings, ACheckPointThatContradictsIsNamed) {
  TestModels made = test_models(with_noise());
  named(made.control, "P101").position.z() += 2;
  const ModelsReport report = joined(std::move(made));
  EXPECT_EQ(codes_of(report), std::vector<FindingCode>{FindingCode::kCheckPoint});
  EXPECT_NEAR(*report.findings.front().figure(FigureName::kOffset), 2, 0.2);
}

TEST(ModelFindings, SigmasThatAreStatedTooLargeAreNoted) {
  TestModels made = test_models(with_noise());
  for (StereoModel& model : made.models)
    for (NamedPoint& point : model.points) point.covariance *= 25;
  const ModelsReport report = joined(std::move(made));
  EXPECT_EQ(codes_of(report), std::vector<FindingCode>{FindingCode::kResidualsSmall});
  EXPECT_NE(models_text(report).find("findings\n  note: Residuals are"), std::string::npos) << models_text(report);
}

}  // namespace
}  // namespace collinea
