// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/partners.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "collinea/match/retrieval.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

// Images in groups of five that see the same 300 things, a little changed; none of the groups' images are neighbours by
// number.
struct Library {
  static constexpr std::uint32_t kGroups = 9, kPerGroup = 5, kCount = kGroups * kPerGroup;

  static Features features(ImageId image) {
    Random things(1000 + image.value % kGroups), change(image.value);
    Features features;
    for (std::uint32_t i = 0; i < 300; ++i) {
      Descriptor descriptor;
      for (std::uint8_t& value : descriptor) value = static_cast<std::uint8_t>(things.below(80) + change.below(10));
      features.descriptors.push_back(descriptor);
      features.keypoints.push_back({.scale_px = static_cast<float>(1 + i % 50), .strength = 1});
    }
    return features;
  }
  static std::vector<ImageId> images() {
    std::vector<ImageId> list;
    for (std::uint32_t i = 0; i < kCount; ++i) list.push_back(ImageId{i});
    return list;
  }
  static std::map<ImageId, Glance> seen(int count) {
    PairOptions options;
    options.look_features = count;
    return glances(images(), features, options, {}).value();
  }
};

ImageIdPair pair_of(std::uint32_t a, std::uint32_t b) { return {ImageId{a}, ImageId{b}}; }

LookedPair looked_pair(std::uint32_t a, std::uint32_t b, std::uint32_t matches) {
  LookedPair pair{pair_of(a, b), {}};
  for (std::uint32_t i = 0; i < matches; ++i) pair.matches.emplace_back(i, i);
  return pair;
}

TEST(Look, FindsTheImagesThatShowTheSameInTermsOfTheirFeatures) {
  const auto seen = Library::seen(40);
  const auto looked = look(seen, {pair_of(0, 9), pair_of(0, 1)}, {});
  ASSERT_TRUE(looked);
  ASSERT_EQ(looked->size(), 2u);
  EXPECT_GT(looked->at(0).matches.size(), 30u);
  EXPECT_LT(looked->at(1).matches.size(), 5u);
  for (const auto& [i, j] : looked->at(0).matches) {
    EXPECT_EQ(i, j);
    EXPECT_GE(i % 50, 43u);  // the 40 largest of 300
  }
}

TEST(Look, ErrorsAndStopsArePassedOn) {
  const auto broken = [](ImageId image) -> Result<Features> {
    if (image.value == 7) return fail(Errc::kNotFound, "no features");
    return Features{};
  };
  EXPECT_EQ(glances(Library::images(), broken, {}, {}).error().code, Errc::kNotFound);
  std::stop_source source;
  source.request_stop();
  collinea::Run run;
  run.stop = source.get_token();
  EXPECT_EQ(glances(Library::images(), Library::features, {}, run).error().code, Errc::kCancelled);
  EXPECT_EQ(look(Library::seen(16), {pair_of(0, 9)}, run).error().code, Errc::kCancelled);
  EXPECT_EQ(similar_pairs(Library::seen(16), {}, run).error().code, Errc::kCancelled);
}

TEST(SimilarPairs, AreThoseOfTheSameGroupWhateverTheThreads) {
  const auto seen = Library::seen(100);
  PairOptions options;
  options.candidates = Library::kPerGroup - 1;
  collinea::Run run;
  const auto pairs = similar_pairs(seen, options, run);
  ASSERT_TRUE(pairs);
  EXPECT_EQ(pairs->size(), std::size_t{Library::kGroups * 10});
  for (const auto& [a, b] : *pairs) EXPECT_EQ(a.value % Library::kGroups, b.value % Library::kGroups);
  run.threads = 3;
  EXPECT_EQ(similar_pairs(seen, options, run).value(), *pairs);
}

TEST(SimilarPairs, OfASmallBlockAreAllAndImagesWithoutFeaturesDoNoHarm) {
  auto seen = Library::seen(16);
  EXPECT_EQ(similar_pairs(seen, {}, {}).value().size(), std::size_t{Library::kCount * (Library::kCount - 1) / 2});
  PairOptions options;
  options.candidates = 3;
  seen[ImageId{4}] = {};
  EXPECT_LE(similar_pairs(seen, options, {}).value().size(), std::size_t{Library::kCount * 3});
  EXPECT_TRUE(similar_pairs({}, options, {}).value().empty());
  for (auto& [image, glance] : seen) glance = {};
  EXPECT_FALSE(similar_pairs(seen, options, {}).value().empty());
}

TEST(SurePairs, AreTheBestOfEachImageIfTheyPromiseAnything) {
  PairOptions options;
  options.sure_partners = 1;
  const std::vector looked{looked_pair(0, 1, 30), looked_pair(0, 2, 20), looked_pair(1, 2, 10), looked_pair(2, 3, 4)};
  EXPECT_EQ(sure_pairs(looked, options), (std::vector{pair_of(0, 1), pair_of(0, 2)}));
  options.sure_partners = 2;
  EXPECT_EQ(sure_pairs(looked, options), (std::vector{pair_of(0, 1), pair_of(0, 2), pair_of(1, 2)}));
}

TEST(LackingPairs, AreThoseWhoseMatchesTheTracksDoNotHold) {
  const std::vector looked{looked_pair(0, 1, 30), looked_pair(0, 2, 20), looked_pair(1, 2, 10)};
  std::vector<Track> tracks;
  for (std::uint32_t i = 0; i < 8; ++i) tracks.push_back({{{ImageId{0}, i}, {ImageId{1}, i}, {ImageId{2}, i}}});
  // 8 of the 20 matches of (0, 2) are linked, and 8 of the 10 of (1, 2).
  EXPECT_EQ(lacking_pairs(looked, {pair_of(0, 1)}, tracks, {}), std::vector{pair_of(0, 2)});
  PairOptions options;
  options.max_linked = 0.3;
  EXPECT_TRUE(lacking_pairs(looked, {pair_of(0, 1)}, tracks, options).empty());
  options.max_linked = 1;
  EXPECT_EQ(lacking_pairs(looked, {pair_of(0, 1)}, tracks, options), (std::vector{pair_of(0, 2), pair_of(1, 2)}));
  options.partners = 1;
  EXPECT_EQ(lacking_pairs(looked, {pair_of(0, 1)}, tracks, options), std::vector{pair_of(0, 2)});
}

TEST(JoiningPairs, AreOfferedToImagesThatHangLooseAndToPartsThatStandAlone) {
  std::vector<LookedPair> looked;
  for (std::uint32_t a = 0; a < 7; ++a)
    for (std::uint32_t b = a + 1; b < 7; ++b) looked.push_back(looked_pair(a, b, 1));
  const std::vector held{pair_of(0, 1), pair_of(0, 2), pair_of(0, 3), pair_of(1, 2), pair_of(1, 3), pair_of(2, 3)};
  const std::vector triangle{pair_of(4, 5), pair_of(4, 6), pair_of(5, 6)};
  auto verified = held;
  verified.insert(verified.end(), triangle.begin(), triangle.end());
  const std::set<ImageIdPair> searched(verified.begin(), verified.end());
  // Two parts: all pairs between them, and only those.
  EXPECT_EQ(joining_pairs(looked, searched, verified, {}).size(), 12u);
  verified.push_back(pair_of(3, 4));
  EXPECT_TRUE(joining_pairs(looked, {verified.begin(), verified.end()}, verified, {}).empty());
  // An image with one partner is offered all others.
  verified = held;
  verified.push_back(pair_of(3, 4));
  verified.insert(verified.end(), {pair_of(0, 5), pair_of(1, 5), pair_of(0, 6), pair_of(1, 6)});
  const auto offered = joining_pairs(looked, {verified.begin(), verified.end()}, verified, {});
  EXPECT_EQ(offered.size(), 5u);
  for (const auto& [a, b] : offered) EXPECT_TRUE(a == ImageId{4} || b == ImageId{4});
  EXPECT_TRUE(joining_pairs({}, {}, {}, {}).empty());
}

TEST(JoiningPairs, OfALargeBlockAreFewForEachImage) {
  std::vector<LookedPair> looked;
  std::vector<ImageIdPair> verified;
  for (std::uint32_t a = 0; a < 80; ++a)
    for (std::uint32_t b = a + 1; b < 80; ++b) {
      looked.push_back(looked_pair(a, b, 1));
      if ((a < 50) == (b < 50)) verified.push_back(pair_of(a, b));
    }
  const auto offered = joining_pairs(looked, {verified.begin(), verified.end()}, verified, {});
  EXPECT_EQ(offered.size(), 30u * 8);
}

TEST(TrackIndex, KnowsWhatImagesHaveInCommon) {
  const std::vector<Track> tracks{{{{ImageId{0}, 5}, {ImageId{1}, 2}, {ImageId{4}, 9}}},
                                  {{{ImageId{0}, 3}, {ImageId{4}, 1}}},
                                  {{{ImageId{1}, 7}, {ImageId{4}, 2}}}};
  const TrackIndex index(tracks);
  const auto shared = index.shared_with_later(ImageId{0}, 2);
  ASSERT_EQ(shared.size(), 1u);
  EXPECT_EQ(shared[0].images, pair_of(0, 4));
  EXPECT_EQ(shared[0].matches, (std::vector<Match>{{3, 1}, {5, 9}}));
  EXPECT_EQ(index.shared_with_later(ImageId{1}, 1).size(), 1u);
  EXPECT_TRUE(index.shared_with_later(ImageId{4}, 1).empty());
  EXPECT_TRUE(index.linked(pair_of(0, 4), {5, 9}));
  EXPECT_FALSE(index.linked(pair_of(0, 4), {5, 1}));
  EXPECT_FALSE(index.linked(pair_of(0, 4), {6, 9}));
  EXPECT_EQ(index.images(), (std::vector{ImageId{0}, ImageId{1}, ImageId{4}}));
}

}  // namespace
}  // namespace collinea
