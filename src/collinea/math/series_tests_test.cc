// SPDX-License-Identifier: Apache-2.0
#include "collinea/math/series_tests.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/math/normal.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Neighbours correlated by `correlation`.
std::vector<double> series(Random& random, std::size_t count, double correlation = 0) {
  std::vector<double> values(count);
  double last = 0;
  for (double& value : values)
    value = last = correlation * last + std::sqrt(1 - correlation * correlation) * random.normal();
  return values;
}

std::vector<double> probabilities(const std::vector<double>& values) {
  std::vector<double> all;
  for (const double value : values) all.push_back(normal_probability(value));
  return all;
}

TEST(SeriesTests, SignChangesAreBinomial) {
  const double up_and_down[] = {1, -1, 1, -1, 1}, one_side[] = {1, 2, 3, 1, 2}, broken[] = {1, 2, kNaN, -3, -1};
  EXPECT_EQ(sign_changes(up_and_down).changes, 4);
  EXPECT_EQ(sign_changes(up_and_down).runs(), 5);
  EXPECT_DOUBLE_EQ(sign_changes(up_and_down).p_value(), 2.0 / 16);
  EXPECT_DOUBLE_EQ(sign_changes(one_side).few_p_value(), 1.0 / 16);
  EXPECT_NEAR(sign_changes(one_side).correlation(), 1, 1e-15);
  EXPECT_EQ(sign_changes(broken).pairs, 2);
  EXPECT_EQ(sign_changes(broken).changes, 0);
  EXPECT_EQ(sign_changes({}).p_value(), 1);
  // The normal distribution takes over where both say the same.
  EXPECT_NEAR((SignChanges{440, 1000}).few_p_value(), (SignChanges{440, 1001}).few_p_value(), 1e-5);
}

// 4000 series each; a share of alpha has the standard deviation sqrt(alpha / 4000), four of which are allowed.
TEST(SeriesTests, FalseAlarmsAreAtTheLevel) {
  for (const std::size_t count : {12u, 40u, 400u}) {
    int runs = 0, lag = 0, distance = 0;
    constexpr int kSeries = 4000;
    constexpr double kLevel = 0.05, kMost = kSeries * kLevel, kSpread = 58;
    for (int i = 0; i < kSeries; ++i) {
      Random random(7 + count, std::uint64_t(i));
      const std::vector<double> values = series(random, count);
      runs += sign_changes(values).p_value() < kLevel;
      lag += lag_one(values).p_value() < kLevel;
      distance += kolmogorov(probabilities(values)).p_value() < kLevel;
    }
    EXPECT_LE(runs, kMost + kSpread) << count;  // few pairs have few levels, all below the stated one
    if (count > 100) {
      EXPECT_GE(runs, kMost / 2);
    }
    EXPECT_NEAR(lag, kMost, kSpread) << count;
    EXPECT_NEAR(distance, kMost, kSpread) << count;
  }
}

TEST(SeriesTests, CorrelatedNeighboursAreFoundWithTheirCorrelation) {
  Random random(3);
  const std::vector<double> values = series(random, 4000, 0.5);
  EXPECT_NEAR(sign_changes(values).correlation(), 0.5, 0.1);
  EXPECT_NEAR(lag_one(values).correlation, 0.5, 0.06);
  EXPECT_LT(sign_changes(values).p_value(), 1e-30);
  EXPECT_LT(lag_one(values).p_value(), 1e-30);
}

TEST(SeriesTests, AnotherDistributionIsFound) {
  Random random(5);
  std::vector<double> values = series(random, 2000);
  for (double& value : values) value *= 1.3;
  const Kolmogorov wider = kolmogorov(probabilities(values));
  EXPECT_NEAR(wider.distance, 0.063, 0.03);
  EXPECT_LT(wider.p_value(), 1e-4);
  // Kolmogorov's own limits, 5 % and 1 %.
  EXPECT_NEAR((Kolmogorov{1.3581 / 1e4, 100000000}).p_value(), 0.05, 1e-4);
  EXPECT_NEAR((Kolmogorov{1.6276 / 1e4, 100000000}).p_value(), 0.01, 1e-4);
}

TEST(SeriesTests, NothingIsSaidOfNothing) {
  EXPECT_EQ(lag_one({}).p_value(), 1);
  const double zeros[] = {0, 0, 0}, missing[] = {kNaN, kNaN};
  EXPECT_EQ(lag_one(zeros).p_value(), 1);
  EXPECT_EQ(lag_one(missing).p_value(), 1);
  EXPECT_EQ(kolmogorov({}).p_value(), 1);
  EXPECT_EQ(kolmogorov({kNaN}).count, 0);
  EXPECT_TRUE(holm({}).empty());
}

TEST(SeriesTests, HolmMultipliesByHowManyAreLeft) {
  const double p[] = {0.03, 0.01, 0.5, 0.011};
  const std::vector<double> corrected = holm(p);
  EXPECT_DOUBLE_EQ(corrected[1], 0.04);
  EXPECT_DOUBLE_EQ(corrected[3], 0.04);  // not below that before it
  EXPECT_DOUBLE_EQ(corrected[0], 0.06);
  EXPECT_DOUBLE_EQ(corrected[2], 0.5);
}

}  // namespace
}  // namespace collinea
