// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/tracks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "collinea/math/random.h"

namespace collinea {
namespace {

ImagePair pair_of(std::uint32_t first, std::uint32_t second, std::vector<Match> matches) {
  ImagePair pair;
  pair.first = ImageId{first};
  pair.second = ImageId{second};
  pair.matches = std::move(matches);
  return pair;
}

Track track(std::vector<std::pair<std::uint32_t, std::uint32_t>> features) {
  Track result;
  for (const auto& [image, feature] : features) result.features.emplace_back(ImageId{image}, feature);
  return result;
}

TEST(MergeTracks, NoMatchesMakeNoTracks) {
  EXPECT_TRUE(merge_tracks(std::span<const ImagePair>()).empty());
  EXPECT_TRUE(merge_tracks(std::vector{pair_of(0, 1, {})}).empty());
}

TEST(MergeTracks, MatchesOfOneFeatureMakeOneTrack) {
  const std::vector pairs{pair_of(1, 2, {{5, 6}}), pair_of(0, 1, {{4, 5}, {9, 8}}), pair_of(2, 7, {{6, 0}})};
  EXPECT_EQ(merge_tracks(pairs), (std::vector{track({{0, 4}, {1, 5}, {2, 6}, {7, 0}}), track({{0, 9}, {1, 8}})}));
}

TEST(MergeTracks, AWrongMatchBetweenTwoTracksPartsThemAgain) {
  // Features 0 of images 0 to 3 belong together, and features 1; all pairs are matched, and 0 with 1 between images 0
  // and 3.
  std::vector<ImagePair> pairs;
  for (std::uint32_t i = 0; i < 4; ++i)
    for (std::uint32_t j = i + 1; j < 4; ++j) pairs.push_back(pair_of(i, j, {{0, 0}, {1, 1}}));
  pairs.push_back(pair_of(0, 3, {{0, 1}}));
  EXPECT_EQ(merge_tracks(pairs),
            (std::vector{track({{0, 0}, {1, 0}, {2, 0}, {3, 0}}), track({{0, 1}, {1, 1}, {2, 1}, {3, 1}})}));
}

TEST(MergeTracks, ALonelyWrongFeatureIsLeftOut) {
  // Feature 9 of image 0 is linked by one match only, feature 0 by three.
  const std::vector pairs{pair_of(0, 1, {{0, 0}}), pair_of(0, 2, {{0, 0}}), pair_of(1, 2, {{0, 0}}),
                          pair_of(2, 3, {{0, 0}}), pair_of(1, 3, {{0, 0}}), pair_of(0, 3, {{9, 0}})};
  EXPECT_EQ(merge_tracks(pairs), (std::vector{track({{0, 0}, {1, 0}, {2, 0}, {3, 0}})}));
}

TEST(MergeTracks, NoImageIsTwiceInATrackAndTheOrderOfThePairsDoesNotMatter) {
  Random random(4);
  std::vector<ImagePair> pairs;
  std::set<std::pair<ImageId, std::uint32_t>> matched;
  for (std::uint32_t i = 0; i < 12; ++i)
    for (std::uint32_t j = i + 1; j < 12; ++j) {
      std::vector<Match> matches;
      // Every feature matches its like, and one in ten any other.
      for (std::uint32_t k = 0; k < 40; ++k)
        if (random.uniform() < 0.5) matches.emplace_back(k, random.uniform() < 0.9 ? k : random.below(40));
      for (const auto& [a, b] : matches) {
        matched.emplace(ImageId{i}, a);
        matched.emplace(ImageId{j}, b);
      }
      pairs.push_back(pair_of(i, j, matches));
    }
  const std::vector<Track> tracks = merge_tracks(pairs);
  std::set<std::pair<ImageId, std::uint32_t>> seen;
  std::size_t pure = 0;
  for (const Track& one : tracks) {
    ASSERT_GE(one.features.size(), 2u);
    for (std::size_t i = 0; i < one.features.size(); ++i) {
      if (i > 0) {
        ASSERT_LT(one.features[i - 1].first, one.features[i].first);
      }
      ASSERT_TRUE(matched.contains(one.features[i]));
      ASSERT_TRUE(seen.insert(one.features[i]).second) << "in two tracks";
    }
    const std::uint32_t like = one.features.front().second;
    pure +=
        one.features.size() >= 10 && std::ranges::all_of(one.features, [&](const auto& f) { return f.second == like; });
  }
  EXPECT_GE(pure, 38u);  // of 40

  std::ranges::reverse(pairs);
  for (ImagePair& pair : pairs) std::ranges::reverse(pair.matches);
  EXPECT_EQ(merge_tracks(pairs), tracks);
}

}  // namespace
}  // namespace collinea
