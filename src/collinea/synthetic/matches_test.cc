// SPDX-License-Identifier: Apache-2.0
#include "collinea/synthetic/matches.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "collinea/synthetic/survey.h"

namespace collinea {
namespace {

const collinea::Run kRun;
const ObservationOptions kOptions{.points_per_image = 80, .seed = 4};

const Block& block() {
  static const Block made = [] {
    SurveyOptions options;
    options.images = 12;
    options.control_points = options.check_points = 0;
    return *observations_only(*make_survey(options), kOptions, kRun);
  }();
  return made;
}

TEST(SimulatedMatches, AsManyAreMissingAndWrongAsAskedFor) {
  const SimulatedMatches matches = simulated_matches(block(), kOptions, 8, kRun);
  std::map<std::pair<ImageId, std::uint32_t>, PointId> point_of;
  for (const Observation& seen : block().observations) point_of[{seen.image, seen.feature}] = seen.point;
  double right = 0, wrong = 0, possible = 0;
  for (const ImagePair& pair : matches.pairs) {
    std::map<PointId, int> images;
    for (const Observation& seen : block().observations)
      if (seen.image == pair.first || seen.image == pair.second) possible += ++images[seen.point] == 2;
    for (const auto& [i, j] : pair.matches)
      (point_of.at({pair.first, i}) == point_of.at({pair.second, j}) ? right : wrong) += 1;
  }
  // Four standard deviations of a binomial share; a few right matches give way to wrong ones at the same feature.
  const double found = right + wrong;
  EXPECT_NEAR(wrong / found, kOptions.wrong_share, 4 * std::sqrt(0.04 / found) + 0.005);
  EXPECT_NEAR(found / possible, kOptions.matched_share, 4 * std::sqrt(0.16 / possible) + 0.04);
}

TEST(SimulatedMatches, NoFeatureIsMatchedTwiceInAPair) {
  for (const ImagePair& pair : simulated_matches(block(), kOptions, 8, kRun).pairs) {
    std::set<std::uint32_t> first, second;
    for (const auto& [i, j] : pair.matches) {
      EXPECT_TRUE(first.insert(i).second);
      EXPECT_TRUE(second.insert(j).second);
    }
    EXPECT_GE(pair.matches.size(), 8u);
  }
}

TEST(SimulatedMatches, DoNotDependOnThreads) {
  collinea::Run two;
  two.threads = 2;
  const SimulatedMatches a = simulated_matches(block(), kOptions, 8, kRun),
                         b = simulated_matches(block(), kOptions, 8, two);
  ASSERT_EQ(a.pairs.size(), b.pairs.size());
  for (std::size_t i = 0; i < a.pairs.size(); ++i) EXPECT_EQ(a.pairs[i].matches, b.pairs[i].matches);
}

}  // namespace
}  // namespace collinea
