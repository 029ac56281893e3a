// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/variance_components.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "collinea/quality/internal/test_examine.h"

namespace collinea {
namespace {

using testing::test_block;

ExamineOptions plain() {
  return {.adjust = {.calibration = Calibration::kFocal, .loss = Loss::kNone, .position_loss = Loss::kNone}};
}

constexpr double kSettled = 0.01;  // factors are repeated until none changes by more

// Sigmas wrong threefold, in both directions. A factor is known by factor / sqrt(2 sum r^2); the mean of 20 blocks by 1
// / sqrt(20) of that: four of those, and what the iteration leaves. Of the bound itself is asked that it would see an
// eighth of what was wrong.
TEST(VarianceComponents, WrongSigmasAreRecovered) {
  const SigmaFactors wrong = {3, 1 / 3.0, 1 / 3.0, 3, 3, 1 / 3.0};
  SigmaFactors sum{}, variance{};
  constexpr int kBlocks = 20;
  constexpr auto kGroupsHere = static_cast<std::size_t>(ObservationGroup::kDistance);  // nothing on the ground
  for (std::uint64_t seed = 1; seed <= kBlocks; ++seed) {
    const Block block = test_block({.rows = 3,
                                    .columns = 4,
                                    .points = 40,
                                    .sigma_px = 0.5,
                                    .position_sigma_m = 0.05,
                                    .control = 36,
                                    .control_sigma_m = 0.05,
                                    .seed = seed});
    const auto found = estimate_variance_components(with_sigmas(block, wrong), {}, plain(), {});
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_TRUE(found->converged);
    EXPECT_NEAR(found->adjusted.sigma0, 1, kSettled);  // a mean of the factors that are left
    for (std::size_t g = 0; g < kGroupsHere; ++g) {
      sum[g] += found->factors[g] * wrong[g];
      variance[g] += std::pow(found->sigma[g] * wrong[g], 2);
    }
  }
  for (std::size_t g = 0; g < kGroupsHere; ++g) {
    EXPECT_NEAR(sum[g] / kBlocks, 1, 4 * std::sqrt(variance[g]) / kBlocks + kSettled) << "group " << g;
    EXPECT_LT(4 * std::sqrt(variance[g]) / kBlocks, (3 - 1) / 8.0) << "group " << g;
  }
}

TEST(VarianceComponents, AGroupWithoutRedundancyKeepsItsSigmas) {
  const Block block = test_block({.rows = 2, .columns = 3, .points = 60, .sigma_px = 0.5, .control = 0});
  const auto found = estimate_variance_components(block, {}, plain(), {});
  ASSERT_TRUE(found) << found.error().message;
  for (std::size_t g = 1; g < kObservationGroups; ++g) EXPECT_EQ(found->factors[g], 1);
  EXPECT_NEAR(found->factors[0], 1, 4 * found->sigma[0]);
  EXPECT_LT(4 * found->sigma[0], 0.3);
  EXPECT_EQ(found->sigma[3], 0);
}

// By the traits of the groups, each with a factor of its own.
TEST(VarianceComponents, SigmasOfACoordinateAreMultipliedByTheFactorOfItsGroup) {
  Block block =
      test_block({.rows = 2, .columns = 2, .points = 9, .sigma_px = 0.5, .position_sigma_m = 0.05, .control = 4});
  ASSERT_FALSE(block.control_observations.empty());
  for (std::size_t kind = 0; kind < kGeodeticKinds; ++kind)
    block.geodetic.push_back({.kind = static_cast<GeodeticKind>(kind), .sigma = 0.1});
  SigmaFactors factors;
  for (std::size_t g = 0; g < kObservationGroups; ++g) factors[g] = 2 + double(g);
  const auto factor = [&](ObservationGroup group) { return factors[static_cast<std::size_t>(group)]; };
  const Block scaled = with_sigmas(block, factors);

  const auto px = [&](const auto& before, const auto& after, ObservationGroup group) {
    for (std::size_t i = 0; i < before.size(); ++i)
      EXPECT_EQ(after[i].sigma_px, before[i].sigma_px * factor(group)) << "group " << int(group);
  };
  px(block.observations, scaled.observations, ObservationGroup::kTieImages);
  px(block.control_observations, scaled.control_observations, ObservationGroup::kControlImages);
  for (const ObservationGroupTraits& its : kObservationGroupTraits)
    for (int axis = its.first_axis; axis < its.first_axis + its.axes; ++axis) {
      if (its.source == ObservationSource::kControlCoordinates) {
        for (const auto& [id, control] : block.control)
          if (control.role == ControlRole::kControl) {
            EXPECT_EQ(scaled.control.at(id).sigma_m[axis], control.sigma_m[axis] * factor(its.group));
          }
      }
      if (its.source == ObservationSource::kPosition) {
        for (const auto& [id, image] : block.images)
          EXPECT_EQ(scaled.images.at(id).position->sigma_m[axis], image.position->sigma_m[axis] * factor(its.group));
      }
    }
  for (std::size_t kind = 0; kind < kGeodeticKinds; ++kind)
    EXPECT_EQ(scaled.geodetic[kind].sigma, 0.1 * factor(group_of(static_cast<GeodeticKind>(kind))));
}

TEST(VarianceComponents, FactorsAreKeptByTheWordsOfTheirGroups) {
  SigmaFactors factors = as_given();
  EXPECT_TRUE(factors_by_word(factors).empty());
  factors[static_cast<std::size_t>(ObservationGroup::kControlHeight)] = 2.5;
  EXPECT_EQ(factors_by_word(factors), (std::map<std::string, double>{{"control_height", 2.5}}));
  for (std::size_t g = 0; g < kObservationGroups; ++g) factors[g] = 2 + double(g) / 3;
  std::map<std::string, double> by_word = factors_by_word(factors);
  EXPECT_EQ(by_word.size(), kObservationGroups);
  EXPECT_EQ(factors_of(by_word), factors);
  by_word["of no group"] = 7;
  EXPECT_EQ(factors_of(by_word), factors);
}

TEST(VarianceComponents, CheckPointsKeepTheirSigmas) {
  const Block block = test_block({.rows = 2, .columns = 3, .points = 20, .sigma_px = 0.5, .control = 6});
  const Block scaled = with_sigmas(block, {1, 1, 3, 3, 1, 1});
  for (const auto& [id, control] : block.control)
    EXPECT_DOUBLE_EQ(scaled.control.at(id).sigma_m.x() / control.sigma_m.x(),
                     control.role == ControlRole::kControl ? 3 : 1);
}

}  // namespace
}  // namespace collinea
