// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/residual_tests.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "collinea/quality/internal/image_order.h"
#include "collinea/quality/internal/test_examine.h"
#include "collinea/quality/internal/tie_marginal.h"
#include "collinea/quality/test_flight.h"

namespace collinea {
namespace {

using namespace testing;
using Kind = ResidualTestKind;
using Series = ResidualSeries;

constexpr FlightOptions kFlight{.strips = 2, .images = 14, .points = 400};

Examined examined_flight(const Flown& made) {
  ExamineOptions options{.adjust = plain()};
  options.reliability = true;
  options.systematics = made.systematics;
  options.systematics.test = false;
  return *examine(made.block, made.scope, options, Run());
}

std::vector<ResidualTest> tests_of(const Flown& made, double level = 0.05) {
  return residual_tests(made.block, examined_flight(made), made.systematics.strips, level);
}

const ResidualTest* find(const std::vector<ResidualTest>& tests, Kind kind, Series series, int axis, int strip = -1) {
  const auto its = std::ranges::find_if(tests, [&](const ResidualTest& test) {
    return test.kind == kind && test.series == series && test.axis == axis && test.strip.value_or(-1) == strip;
  });
  return its == tests.end() ? nullptr : &*its;
}

// Of 150 blocks without anything wrong. Of n tests at 5 % the share has the standard deviation sqrt(0.05 * 0.95 / n),
// four of which are allowed; tests of one block are nearly independent. Sign changes have few levels, and images and
// their means are tested on the safe side.
TEST(ResidualTests, FalseAlarmsAreAtTheLevel) {
  constexpr int kBlocks = 150;
  std::map<std::pair<Kind, Series>, std::pair<double, double>> alarms;  // of how many
  double any = 0;
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    bool one = false;
    for (const ResidualTest& test : tests_of(flown(seed, {}, kFlight))) {
      auto& [wrong, all] = alarms[{test.kind, test.series}];
      wrong += test.p_value < 0.05;
      all += 1;
      one |= test.significant;
    }
    any += one;
  }
  EXPECT_LE(any / kBlocks, 0.05 + 4 * std::sqrt(0.05 * 0.95 / kBlocks));
  ASSERT_GE(alarms.size(), 7u);  // and now and then that of a distribution of tie points
  for (const auto& [of, counts] : alarms) {
    const auto [wrong, all] = counts;
    const double share = wrong / all, spread = 4 * std::sqrt(0.05 * 0.95 / all);
    EXPECT_LE(share, 0.05 + spread) << word_of(of.first) << " of " << word_of(of.second) << ", " << all;
    if (of == std::pair(Kind::kAutocorrelation, Series::kPositions) ||
        of == std::pair(Kind::kNormal, Series::kTiePoints))
      EXPECT_GE(share, 0.05 - spread) << word_of(of.first) << " of " << word_of(of.second) << ", " << all;
  }
}

// Positions tie images together that hang together by little else: residuals of neighbours are then correlated without
// anything being wrong, whitened ones are not.
TEST(ResidualTests, ResidualsThatDependOnEachOtherAreMadeIndependent) {
  const FlightOptions weak{.strips = 1, .images = 14, .points = 40, .control = 0, .sigma_px = 4};
  double raw = 0, raw_squares = 0, products = 0, squares = 0, count = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const std::vector<WhitenedPosition> list = examined_flight(flown(seed, {}, weak)).whitened_positions;
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t i = 1; i < list.size(); ++i) {
        const double u = list[i].whitened[axis], before = list[i - 1].whitened[axis];
        if (!std::isfinite(u) || !std::isfinite(before)) continue;
        products += u * before, squares += u * u, count += 1;
        raw += list[i].residual_m[axis] * list[i - 1].residual_m[axis];
        raw_squares += list[i].residual_m[axis] * list[i].residual_m[axis];
      }
  }
  EXPECT_GT(std::abs(raw / raw_squares), 0.1);
  EXPECT_NEAR(products / count, 0, 4 / std::sqrt(count));
  EXPECT_NEAR(squares / count, 1, 4 * std::sqrt(2 / count));
}

// A drift of eight sigmas from end to end of 28 images, at the level of the report for all tests.
TEST(ResidualTests, ADriftOfPositionsIsFoundInTheOrderFlown) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto tests = tests_of(flown(seed, {.drift_m = {0, 0.16, 0}}, kFlight), 0.001);
    const ResidualTest* lag = find(tests, Kind::kAutocorrelation, Series::kPositions, 1);
    ASSERT_TRUE(lag);
    found += lag->significant;
    const std::vector<Finding> findings = residual_findings(tests);
    const bool named = std::ranges::any_of(findings, [](const Finding& finding) {
      return finding.code == FindingCode::kPositionsInOrder && finding.subjects[0].axis == 1 &&
             !finding.remedies.empty();
    });
    EXPECT_EQ(named, lag->significant || find(tests, Kind::kRuns, Series::kPositions, 1)->significant ||
                         std::ranges::any_of(tests, [](const ResidualTest& test) {
                           return test.series == Series::kPositions && test.axis == 1 && test.significant &&
                                  test.kind != Kind::kNormal;
                         }));
  }
  EXPECT_GE(found, 12);
}

TEST(ResidualTests, NeighboursThatAreAlikeInImagesAreFound) {
  const FlightOptions dense{.strips = 1, .images = 6, .points = 900};
  Flown made = flown(1, {}, dense);
  for (Observation& seen : made.block.observations) {
    const Camera& camera = made.block.camera_of(seen.image);
    seen.pixel.y() += 0.7 * std::sin(12 * seen.pixel.x() / camera.width_px);
  }
  const std::vector<Finding> findings = residual_findings(tests_of(made));
  const auto alike = std::ranges::find(findings, FindingCode::kImageResidualsAlike, &Finding::code);
  ASSERT_NE(alike, findings.end());
  EXPECT_GT(*alike->figure(FigureName::kCorrelation), 0.1);
  EXPECT_LT(*alike->figure(FigureName::kChance), 0.05);
}

TEST(ResidualTests, AnotherDistributionOfTiePointsIsNamed) {
  Flown made = flown(1, {}, kFlight);
  Random random(3);
  for (Observation& seen : made.block.observations)
    if (random.uniform() < 0.1) seen.pixel += 3 * Eigen::Vector2d(random.normal(), random.normal());
  Examined adjusted = examined_flight(made);
  adjusted.reliability->tie_errors = {};  // as if they were tested as normal ones
  const auto normal = residual_tests(made.block, adjusted, {}, 0.001);
  EXPECT_TRUE(find(normal, Kind::kNormal, Series::kTiePoints, 0)->significant);
  ASSERT_FALSE(residual_findings(normal).empty());
  EXPECT_EQ(residual_findings(normal).at(0).code, FindingCode::kResidualDistribution);
  // By the distribution that they show they are as expected.
  const auto modelled = tests_of(made);
  ASSERT_TRUE(find(modelled, Kind::kTieErrors, Series::kTiePoints, 0));
  EXPECT_FALSE(find(modelled, Kind::kTieErrors, Series::kTiePoints, 0)->significant);
  EXPECT_TRUE(residual_findings(modelled).empty());
}

TEST(ResidualTests, ABlockWithoutPositionsHasTheOrderOfItsTimes) {
  Flown made = flown(1, {}, kFlight);
  for (auto& [id, image] : made.block.images) {
    image.position.reset();
    image.taken = "2026:05:01 10:00:" + std::to_string(99 - id.value);
  }
  const std::vector<ImageId> order = order_flown(made.block, {});
  EXPECT_EQ(order.size(), made.block.images.size());
  EXPECT_TRUE(std::ranges::is_sorted(order, std::greater{}));
  Examined adjusted = examined_flight(made);
  EXPECT_TRUE(adjusted.whitened_positions.empty());
  EXPECT_FALSE(find(residual_tests(made.block, adjusted, {}, 0.001), Kind::kRuns, Series::kPositions, 0));
  adjusted.reliability.reset();
  EXPECT_TRUE(residual_tests(made.block, adjusted, {}, 0.001).empty());
  EXPECT_TRUE(residual_tests(Block(), Examined(), {}, 0.001).empty());
}

// One coordinate of 40,000 drawn errors: shares within four of their deviations, and the table's 0.001.
TEST(TieMarginal, IsThatOfOneCoordinateOfTheErrors) {
  ErrorDistribution errors{.scale = 1.3, .degrees_of_freedom = 3, .gross_share = 0.05, .gross_radius = 12};
  errors.largest = 10;
  const TieMarginal marginal(errors);
  Random random(1);
  std::vector<double> drawn;
  while (drawn.size() < 40000) {
    Eigen::Vector2d error(random.normal(), random.normal());
    if (random.uniform() < errors.gross_share) {
      error = 12 * Eigen::Vector2d(random.uniform(-1, 1), random.uniform(-1, 1));
      if (error.norm() > 12) error = 12 * std::sqrt(random.uniform()) * error.normalized();
    } else {
      double chi2 = 0;
      for (int i = 0; i < 3; ++i) chi2 += std::pow(random.normal(), 2);
      error *= errors.scale / std::sqrt(chi2 / 3);
      if (error.norm() > errors.largest) continue;
    }
    drawn.push_back(error.x());
  }
  for (const double at : {-8.0, -3.0, -1.0, 0.0, 0.3, 1.0, 2.0, 5.0, 11.0}) {
    const double share = double(std::ranges::count_if(drawn, [&](double x) { return x < at; })) / double(drawn.size());
    EXPECT_NEAR(marginal(at), share, 0.001 + 4 * std::sqrt(0.25 / double(drawn.size()))) << at;
  }
}

}  // namespace
}  // namespace collinea
