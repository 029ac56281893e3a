// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/systematic_findings.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace collinea {
namespace {

Block block_with_camera() {
  Block block;
  block.cameras[{1}].name = "FC6310";
  block.cameras[{1}].prior.calibrate = true;
  return block;
}

SystematicTest test_of(SystematicKind kind, double p_value) {
  SystematicTest test{.kind = kind, .camera = CameraId{1}, .values = {0.037}, .sigmas = {0.003}, .unit = "s"};
  test.statistic = 170;
  test.degrees = 1;
  test.p_value = test.p_corrected = p_value;
  test.effect_unit = "m";
  test.ground_change_sigmas = 2;
  test.determined = test.significant = true;
  return test;
}

TEST(SystematicFindings, NameWhatStandsForItselfWithWhatCannotBeToldFromIt) {
  std::vector<SystematicTest> tests = {test_of(SystematicKind::kLeverArm, 1e-20),
                                       test_of(SystematicKind::kTimeOffset, 1e-30),
                                       test_of(SystematicKind::kAffinity, 1e-5), test_of(SystematicKind::kBowl, 0.5)};
  tests[0].explained_by = 1;
  tests[0].indistinguishable = {1};
  tests[1].indistinguishable = {0};
  tests[2].effect_unit = "px";
  tests[2].ground_change_sigmas = 0.1;
  tests[3].significant = false;
  const std::vector<Finding> findings = systematic_findings(tests, block_with_camera());
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].code, FindingCode::kSystematic);
  EXPECT_EQ(findings[0].severity, Severity::kWeak);
  EXPECT_EQ(findings[0].subjects,
            (std::vector{Subject(CameraId{1}, Aspect::kTimeOffset), Subject(CameraId{1}, Aspect::kLeverArm)}));
  EXPECT_EQ(findings[0].figure(FigureName::kValue), 0.037);
  EXPECT_EQ(findings[0].figure(FigureName::kChance), 1e-30);
  EXPECT_EQ(findings[0].remedies, std::vector{Remedy(OptionName{"time_offset"})});
  EXPECT_EQ(findings[1].subjects[0].aspect, Aspect::kAffinity);
  EXPECT_EQ(findings[1].severity, Severity::kNote);
  EXPECT_TRUE(findings[1].figure(FigureName::kOffsetPx));
}

TEST(SystematicFindings, EveryKindHasAnAspectAndARemedy) {
  for (const auto& one : kSystematicKindWords) {
    const std::vector<Finding> findings = systematic_findings({test_of(one.value, 1e-9)}, block_with_camera());
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_NE(findings[0].subjects[0].aspect, Aspect::kWhole) << one.word;
    EXPECT_FALSE(findings[0].remedies.empty()) << one.word;
  }
}

// One who gave a camera is not told to give one.
TEST(SystematicFindings, OfAGivenCameraTheRemedyIsNotToGiveOne) {
  Block block = block_with_camera();
  block.cameras[{1}].prior.calibrate = false;
  for (const SystematicKind kind : {SystematicKind::kBowl, SystematicKind::kAffinity, SystematicKind::kAdditional})
    for (const double multiple_correlation : {0.5, 0.9999}) {
      SystematicTest test = test_of(kind, 1e-9);
      test.multiple_correlation = multiple_correlation;
      const std::vector<Finding> findings = systematic_findings({test}, block);
      ASSERT_EQ(findings.size(), 1u);
      EXPECT_FALSE(findings[0].remedies.empty());
      EXPECT_EQ(std::ranges::count(findings[0].remedies, Remedy(RemedyCode::kCalibrateCamera)), 0);
    }
}

}  // namespace
}  // namespace collinea
