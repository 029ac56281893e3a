// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/fit_findings.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/math/random.h"
#include "collinea/report/findings_text.h"

namespace collinea {
namespace {

std::vector<FindingCode> codes_of(const VarianceTest& variance, std::span<const ControlTest> control = {}) {
  std::vector<Finding> findings;
  add_fit_findings(variance, control, findings);
  std::vector<FindingCode> codes;
  for (const Finding& finding : findings) codes.push_back(finding.code);
  return codes;
}

// sigma0 1.51 with redundancy 17 happens once in five hundred: that is no agreement.
TEST(VarianceTest, RareResidualsDoNotAgree) {
  const VarianceTest rare{1.51, 17, true};
  EXPECT_NEAR(rare.chance_of_more(), 0.0019, 0.0002);
  EXPECT_EQ(rare.verdict(), VarianceVerdict::kTooLarge);
  EXPECT_EQ(variance_text(rare).find("agrees"), std::string::npos) << variance_text(rare);
  EXPECT_NE(variance_text(rare).find("larger than the stated sigmas allow"), std::string::npos);
  EXPECT_EQ((VarianceTest{1.3, 17, true}).verdict(), VarianceVerdict::kAgrees);  // one in six
  EXPECT_NE(variance_text({1.3, 17, true}).find("agrees with the stated sigmas"), std::string::npos);
  EXPECT_EQ((VarianceTest{0.5, 17, true}).verdict(), VarianceVerdict::kTooSmall);
  EXPECT_EQ((VarianceTest{1.51, 17, false}).verdict(), VarianceVerdict::kNotTested);  // it estimates them
  EXPECT_EQ((VarianceTest{1, 0, true}).verdict(), VarianceVerdict::kNotTested);
}

// Of right sigmas each verdict of disagreement comes with a chance of a hundredth: of 4000 tests 40, with a standard
// deviation of 6.3; four of them leave one false alarm in 16,000 seeds.
TEST(VarianceTest, RightSigmasAreDoubtedAsOftenAsStated) {
  int large = 0, small = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    Random random(seed, 4);
    double squares = 0;
    for (int i = 0; i < 12; ++i) squares += std::pow(random.normal(), 2);
    const VarianceTest test{std::sqrt(squares / 12), 12, true};
    large += test.verdict() == VarianceVerdict::kTooLarge;
    small += test.verdict() == VarianceVerdict::kTooSmall;
  }
  EXPECT_NEAR(large, 40, 26);
  EXPECT_NEAR(small, 40, 26);
}

// 0.05 of 4000 tables of 60 tests have a larger one by chance: 200 with a standard deviation of 14, four of which are
// allowed. Were each tested at 0.05, 0.95 of them had.
TEST(VarianceTest, TheLargestOfManyIsBeyondItsLimitAsOftenAsStated) {
  const double limit = VarianceTest{1, 50, true, 0.05}.limit(60);
  int beyond = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    Random random(seed, 5);
    double largest = 0;
    for (int i = 0; i < 60; ++i) largest = std::max(largest, std::abs(random.normal()));
    beyond += largest > limit;
  }
  EXPECT_NEAR(beyond, 200, 56);
}

// sigma0 of two degrees of freedom is far from sure: deviations in it are Student's. tau, at most root 2, would doubt
// three check coordinates of ten.
TEST(VarianceTest, ChecksAreDoubtedAsOftenAsStatedWhereSigmasAreUnknown) {
  const double limit = VarianceTest{1, 2, false, 0.05}.limit_of_checks();
  int beyond = 0;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    Random random(seed, 6);
    const double sigma0 = std::hypot(random.normal(), random.normal()) / std::sqrt(2.0);
    beyond += std::abs(random.normal()) / sigma0 > limit;
  }
  EXPECT_NEAR(beyond, 200, 56);
}

TEST(FitFindings, AreMadeOfWhatContradicts) {
  using C = FindingCode;
  std::vector<ControlTest> control{{"A", {0.01, 0.02, 0}, {1, 2, 0}}, {"B", {0.3, 0.1, 0}, {2.9, -3.1, 0}}};
  EXPECT_TRUE(codes_of({1.1, 20, true}, control).empty());
  control.push_back({"C", {0.1, -0.9, 0.2}, {1, -8.5, 3.4}});
  control.push_back({"D", {0.1, 0.5, 0.2}, {1, 5.5, 0.4}});  // the shadow of C
  EXPECT_EQ(codes_of({1.1, 20, true}, control), std::vector<C>{C::kControlContradicts});
  EXPECT_EQ(codes_of({3, 20, true}, control), (std::vector<C>{C::kResidualsLarge, C::kControlContradicts}));
  EXPECT_EQ(codes_of({0.2, 20, true}), std::vector<C>{C::kResidualsSmall});
  EXPECT_TRUE(codes_of({3, 20, false}).empty());
  EXPECT_TRUE(codes_of({3, 0, true}, control).empty());
  std::vector<Finding> findings;
  add_fit_findings({1.1, 20, true}, control, findings);
  EXPECT_EQ(findings.front().subjects.front().name, "C");
  EXPECT_EQ(findings.front().figure(FigureName::kOffset), 0.9);
  EXPECT_EQ(findings.front().figure(FigureName::kTest), 8.5);
  const std::string text = findings_text(findings);
  EXPECT_TRUE(text.starts_with("findings\n  wrong: Control point C contradicts the others in Y by 0.9 m")) << text;
  EXPECT_EQ(findings_text({}), "");
}

TEST(FitFindings, MeasurementsAreNamedAndManyRejectedAreWeak) {
  using C = FindingCode;
  const std::vector<MeasurementTest> tests{{"1", "A", 1.2}, {"2", "B", 3.5}, {"3", "A", 4.1}};
  std::vector<Finding> findings;
  add_measurement_findings({1.1, 20, true}, std::span(tests).first(1), findings);
  EXPECT_TRUE(findings.empty());
  add_measurement_findings({1.1, 20, true}, tests, findings);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, C::kMeasurementContradicts);
  EXPECT_EQ(findings[0].subjects, (std::vector<Subject>{Subject::point("3"), Subject::image_named("A")}));
  EXPECT_TRUE(findings_text(findings).starts_with("findings\n  wrong: The measurement of point 3 in A contradicts"))
      << findings_text(findings);
  findings.clear();
  add_measurement_findings({0, 0, true}, tests, findings);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].code, C::kNothingChecks);
  const std::vector<Subject> rejected{Subject::point("1"), Subject::point("2")};
  for (const std::size_t of : {10, 9, 5}) {
    findings.clear();
    add_rejected_finding(C::kMeasurementsRejected, rejected, of, findings);
    ASSERT_EQ(findings.size(), 1u);
    EXPECT_EQ(findings[0].severity, of == 10 ? Severity::kNote : Severity::kWeak);
  }
  findings.clear();
  add_rejected_finding(C::kMeasurementsRejected, {}, 5, findings);
  EXPECT_TRUE(findings.empty());
  const std::string json = findings_json_text(std::vector<Finding>{finding_of(C::kNothingChecks)});
  EXPECT_NE(json.find("\"code\": \"nothing_checks\""), std::string::npos) << json;
}

}  // namespace
}  // namespace collinea
