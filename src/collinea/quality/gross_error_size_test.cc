// SPDX-License-Identifier: Apache-2.0
// Gross errors of every size in everything that is measured on the ground.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "collinea/adjust/survey_block.h"
#include "collinea/quality/snooping.h"

namespace collinea {
namespace {

using testing::Surveyed;
using testing::surveyed_every_way;

const Run kRun;
constexpr int kMost = 1000;

ExamineOptions options() {
  return {.adjust = {.calibration = Calibration::kNone, .loss = Loss::kNone, .position_loss = Loss::kNone},
          .reliability = true,
          .test = {.normal_ties = true}};
}

bool is_rejected(const Snooped& snooped, const TestedObservation& one) {
  return std::any_of(snooped.rejected.begin(), snooped.rejected.end(), [&](const Rejected& rejected) {
    return rejected.group == one.group && rejected.geodetic == one.source;
  });
}

// The best checked observation of a kind.
TestedObservation best_checked(const Reliability& tests, ObservationGroup group) {
  TestedObservation best;
  for (const TestedObservation& one : tests.others)
    if (one.group == group && one.redundancy > best.redundancy) best = one;
  return best;
}

// A blunder that is certain to show goes, however large, and little goes with it that would not have gone without (two
// that were just within the limit): sigma0, which it enlarges, shall not make its neighbours look worse than itself.
// Also where image points are twice as bad as stated, so that tests of what is measured on the ground scale differently
// with their redundancy.
TEST(GrossErrorSize, AGrossErrorOnTheGroundGoesHoweverLargeItIs) {
  std::array<int, kGeodeticKinds> tried{};
  for (const double px : {1.0, 2.0})
    for (const std::uint64_t seed : {1, 2}) {
      const Surveyed made = surveyed_every_way(seed, px);
      const auto clean = examine(made.block, made.scope, options(), kRun);
      const auto before = snoop(made.block, made.scope, options(), kMost, kRun);
      ASSERT_TRUE(clean && clean->reliability && before);
      for (std::size_t kind = 0; kind < kGeodeticKinds; ++kind) {
        const TestedObservation one = best_checked(*clean->reliability, group_of(static_cast<GeodeticKind>(kind)));
        ASSERT_GT(one.redundancy, 0.1) << kGeodeticKindNames[kind];
        for (const double sigmas : {25.0, 66.0, 500.0}) {
          if (sigmas < 2 * one.minimal_detectable_bias / one.sigma)
            continue;  // this is found but for one in a hundred thousand
          ++tried[kind];
          Surveyed wrong = made;
          wrong.block.geodetic[one.source].value += sigmas * one.sigma;
          const auto snooped = snoop(wrong.block, wrong.scope, options(), kMost, kRun);
          ASSERT_TRUE(snooped) << snooped.error().message;
          EXPECT_TRUE(is_rejected(*snooped, one)) << kGeodeticKindNames[kind] << " " << sigmas << " seed " << seed;
          EXPECT_TRUE(snooped->finished);
          EXPECT_LE(snooped->rejected.size(), before->rejected.size() + 3) << kGeodeticKindNames[kind] << " " << sigmas;
        }
      }
    }
  // Two sizes in each of the four blocks: with a redundancy of 0.1 the minimal detectable bias is 13 sigmas.
  for (std::size_t kind = 0; kind < kGeodeticKinds; ++kind) EXPECT_GE(tried[kind], 8) << kGeodeticKindNames[kind];
}

// Two blunders that have nothing to do with each other, of the same |w|: both go.
TEST(GrossErrorSize, TwoThatAreAsSuspectButDifferentBothGo) {
  Surveyed made = surveyed_every_way(1);
  const auto clean = examine(made.block, made.scope, options(), kRun);
  ASSERT_TRUE(clean && clean->reliability);
  const TestedObservation one = best_checked(*clean->reliability, ObservationGroup::kDirection),
                          other = best_checked(*clean->reliability, ObservationGroup::kOnPlane);
  double size = 40 * other.sigma, ratio = 0;
  Block block;
  for (int repeat = 0; repeat < 5; ++repeat) {
    block = made.block;
    block.geodetic[one.source].value += 40 * one.sigma;
    block.geodetic[other.source].value += size;
    const auto wrong = examine(block, made.scope, options(), kRun);
    ASSERT_TRUE(wrong && wrong->reliability);
    double w[2] = {};
    for (const TestedObservation& test : wrong->reliability->others) {
      if (test.group == one.group && test.source == one.source) w[0] = std::abs(test.suspicion);
      if (test.group == other.group && test.source == other.source) w[1] = std::abs(test.suspicion);
    }
    ratio = w[1] / w[0];
    if (repeat < 4) size /= ratio;
  }
  ASSERT_NEAR(ratio, 1, 0.005);
  const auto snooped = snoop(block, made.scope, options(), kMost, kRun);
  ASSERT_TRUE(snooped) << snooped.error().message;
  EXPECT_TRUE(is_rejected(*snooped, one));
  EXPECT_TRUE(is_rejected(*snooped, other));
}

long rays_of_point(const Block& block, PointId point) {
  return std::ranges::count(block.observations, point, &Observation::point);
}

// Every tenth ray is wrong, by up to 200 sigmas, and some that are not go with them at first. In the end every wrong
// one is out, and of the others those that would be out if the wrong ones had never been measured, and few besides.
TEST(GrossErrorSize, RaysThatWereSpoiltByOthersComeBack) {
  using Rays = std::set<std::pair<PointId, ImageId>>;
  const auto rays_of = [](const Block& block) {
    Rays rays;
    for (const Observation& seen : block.observations) rays.emplace(seen.point, seen.image);
    return rays;
  };
  int put_back = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Block good =
        testing::test_block({.points = 120, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 9, .seed = seed});
    Block without = good;
    without.observations.clear();
    for (std::size_t i = 0; i < good.observations.size(); ++i)
      if (i % 10 != 0) without.observations.push_back(good.observations[i]);
    const auto expected = snoop(without, {}, options(), kMost, kRun);
    ASSERT_TRUE(expected) << expected.error().message;
    const Rays left_without = rays_of(expected->block);
    for (const double sigmas : {40.0, 200.0}) {
      Block block = good;
      for (std::size_t i = 0; i < block.observations.size(); i += 10)
        block.observations[i].pixel.x() += sigmas * block.observations[i].sigma_px;
      const auto snooped = snoop(block, {}, options(), kMost, kRun);
      ASSERT_TRUE(snooped) << snooped.error().message;
      EXPECT_TRUE(snooped->finished);
      put_back += snooped->put_back;
      const auto& left = snooped->block.observations;
      EXPECT_TRUE(std::is_sorted(left.begin(), left.end(), [](const Observation& a, const Observation& b) {
        return std::pair(a.point, a.image) < std::pair(b.point, b.image);
      }));
      const Rays now = rays_of(snooped->block);
      for (const auto& ray : now) EXPECT_TRUE(left_without.contains(ray)) << ray.first.value << " " << ray.second.value;
      // Lost are only those of points with two rays, one of which is wrong.
      for (const auto& ray : left_without)
        if (!now.contains(ray)) {
          EXPECT_EQ(rays_of_point(good, ray.first), 2) << ray.first.value;
          EXPECT_EQ(rays_of_point(without, ray.first), 1) << ray.first.value;
        }
      // What is reported as rejected is what is missing, a point that lost one of two rays without the other.
      std::size_t out = block.observations.size() - left.size();
      for (const Rejected& rejected : snooped->rejected)
        if (rejected.group == ObservationGroup::kTieImages) {
          EXPECT_FALSE(now.contains({rejected.point, rejected.image}));
          out -= rejected.as_pair ? 2 : 1;
        }
      EXPECT_EQ(out, 0u);
    }
  }
  EXPECT_GT(put_back, 0);
}

}  // namespace
}  // namespace collinea
