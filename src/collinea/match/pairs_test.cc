// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "collinea/match/internal/position_tree.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

Image image_of(std::string file) {
  Image image;
  image.file = std::move(file);
  image.camera = CameraId{0};
  return image;
}

Block sequence(std::uint32_t count) {
  Block block;
  for (std::uint32_t i = 0; i < count; ++i) block.images[ImageId{i}] = image_of("IMG_" + std::to_string(i) + ".jpg");
  return block;
}

// Strips 30 m apart, exposures 10 m apart, flown to and fro.
Block strips(std::uint32_t strip_count, std::uint32_t per_strip, double side_m = 30, double forward_m = 10) {
  Block block;
  block.cameras[CameraId{0}] = ideal_camera(3000, 4000, 3000);
  for (std::uint32_t strip = 0; strip < strip_count; ++strip)
    for (std::uint32_t i = 0; i < per_strip; ++i) {
      const std::uint32_t along = strip % 2 == 0 ? i : per_strip - 1 - i, id = strip * per_strip + i;
      Image& image = block.images[ImageId{id}] = image_of("DJI_" + std::to_string(id) + ".JPG");
      image.position = PositionPrior{{along * forward_m, strip * side_m, 100}, {2, 2, 4}};
    }
  return block;
}

bool has(const std::vector<ImageIdPair>& pairs, std::uint32_t a, std::uint32_t b) {
  return std::ranges::binary_search(pairs, ImageIdPair{ImageId{std::min(a, b)}, ImageId{std::max(a, b)}});
}

void expect_sorted_and_once(const std::vector<ImageIdPair>& pairs) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    EXPECT_LT(pairs[i].first, pairs[i].second);
    if (i > 0) {
      EXPECT_LT(pairs[i - 1], pairs[i]);
    }
  }
}

TEST(AllPairs, AreForSmallBlocksAndForWhoAsks) {
  EXPECT_EQ(all_pairs(sequence(20)).size(), 190u);
  expect_sorted_and_once(all_pairs(sequence(20)));
  EXPECT_TRUE(all_pairs({}).empty());
  EXPECT_TRUE(all_pairs(sequence(1)).empty());
  PairOptions options;
  EXPECT_TRUE(all_pairs_wanted(sequence(9), options));
  EXPECT_FALSE(all_pairs_wanted(sequence(10), options));
  options.pairs = PairChoice::kAll;
  EXPECT_TRUE(all_pairs_wanted(sequence(500), options));
}

TEST(CandidatePairs, NeighboursInSpaceAreCandidatesAndFarOnesAreNot) {
  const std::uint32_t per_strip = 20;
  const Block block = strips(8, per_strip);
  const auto pairs = candidate_pairs(block, {});
  expect_sorted_and_once(pairs);
  for (std::uint32_t strip = 0; strip + 1 < 8; ++strip)
    for (std::uint32_t i = 0; i < per_strip; ++i) {
      const std::uint32_t here = strip * per_strip + i, beside = (strip + 1) * per_strip + (per_strip - 1 - i);
      EXPECT_TRUE(has(pairs, here, beside)) << here << " " << beside;
    }
  for (const auto& [a, b] : pairs) {
    const double distance_m =
        (block.images.at(a).position->position_in_world - block.images.at(b).position->position_in_world).norm();
    EXPECT_LT(distance_m, 170);
  }
}

// With 3 m between exposures the 24 nearest all lie in the same strip.
TEST(CandidatePairs, StripsBesideAreFoundEvenWhenTheStripItselfIsDense) {
  const std::uint32_t per_strip = 60;
  PairOptions options;
  options.sequence_overlap = 0;
  const auto pairs = candidate_pairs(strips(3, per_strip, 40, 3), options);
  int without = 0;
  for (std::uint32_t i = 0; i < per_strip; ++i) {
    bool any = false;
    for (std::uint32_t j = per_strip; j < 2 * per_strip; ++j) any = any || has(pairs, i, j);
    without += !any;
  }
  EXPECT_EQ(without, 0);
}

// The list of four times as many images has four times as many pairs, and a little for the edges.
TEST(CandidatePairs, GrowAsTheNumberOfImages) {
  const auto small = candidate_pairs(strips(25, 40), {}), large = candidate_pairs(strips(50, 80), {});
  expect_sorted_and_once(large);
  EXPECT_LT(large.size(), 4.2 * small.size());
  EXPECT_LT(large.size(), 4000u * 32);
}

// A ring of oblique images 100 m above and 100 m outside of what they all look at: the nearest by position are those
// beside, but opposite ones show the same ground.
TEST(CandidatePairs, TiltedCamerasAreNeighboursByWhatTheyLookAt) {
  Block block;
  constexpr std::uint32_t kRings = 6, kPerRing = 12;
  for (std::uint32_t i = 0; i < kRings * kPerRing; ++i) {
    const double angle = 2 * std::numbers::pi * (i % kPerRing) / kPerRing;
    Image& image = block.images[ImageId{i}] = image_of("A" + std::to_string(i) + ".jpg");
    const Eigen::Vector3d middle(150.0 * (i / kPerRing), 0, 100);
    image.position = PositionPrior{middle + 100 * Eigen::Vector3d(std::sin(angle), std::cos(angle), 0), {2, 2, 4}};
    image.position->height_above_start_m = 100;
    image.attitude = AttitudePrior{angle * 180 / std::numbers::pi + 180, -45, 0};
  }
  PairOptions options;
  options.neighbours = kPerRing - 1;
  options.sequence_overlap = 0;
  const auto pairs = candidate_pairs(block, options);
  for (std::uint32_t i = 0; i < kRings * kPerRing; ++i)
    for (std::uint32_t j = i + 1; j < kRings * kPerRing; ++j)
      if (i / kPerRing == j / kPerRing) {
        EXPECT_TRUE(has(pairs, i, j)) << i << " " << j;
      }
  const auto by_position = [&] {
    for (auto& [id, image] : block.images) image.attitude.reset();
    return candidate_pairs(block, options);
  }();
  EXPECT_FALSE(has(by_position, 12, 18));
}

TEST(CandidatePairs, WithoutPositionsTheOrderOfTakingCountsAndNumbersCountAsNumbers) {
  Block block = sequence(120);  // IMG_0 ... IMG_119: as text, IMG_10 would follow IMG_1
  const auto pairs = candidate_pairs(block, {});
  expect_sorted_and_once(pairs);
  for (std::uint32_t i = 0; i + 6 < 120; ++i)
    for (std::uint32_t step = 1; step <= 6; ++step) EXPECT_TRUE(has(pairs, i, i + step));
  EXPECT_FALSE(has(pairs, 10, 17));
  EXPECT_TRUE(has(pairs, 10, 10 + 96));

  // Times win over names, when all images have one.
  for (auto& [id, image] : block.images)
    image.taken = "2024:05:01 10:" + std::to_string(10 + (id.value * 7) % 120 / 2) + ":" +
                  std::to_string(10 + (id.value * 7) % 2 * 30);
  const auto timed = candidate_pairs(block, {});
  EXPECT_TRUE(has(timed, 0, 103));  // 103 * 7 = 721 = 1 (mod 120)
  EXPECT_FALSE(has(timed, 0, 1));
  block.images[ImageId{3}].taken.clear();
  EXPECT_EQ(candidate_pairs(block, {}), pairs);
}

TEST(CandidatePairs, ManyImagesAtOnePositionDoNotBecomeAllWithAll) {
  Block block = sequence(400);
  for (auto& [id, image] : block.images) image.position = PositionPrior{{0, 0, 0}, {5, 5, 10}};
  EXPECT_LT(candidate_pairs(block, {}).size(), 400u * 36);
}

TEST(PositionTree, FindsWhatLookingAtAllFinds) {
  Random random(5);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 300; ++i)  // on a lattice: many equal distances
    points.emplace_back(random.below(8), random.below(8), random.below(3));
  const PositionTree tree(points);
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    std::vector<PositionTree::Neighbour> all;
    for (std::uint32_t j = 0; j < points.size(); ++j)
      if (j != i) all.push_back({(points[j] - points[i]).squaredNorm(), j});
    std::ranges::sort(all);
    all.resize(17);
    EXPECT_EQ(tree.nearest(i, 17), all);
  }
  EXPECT_TRUE(PositionTree({{1, 2, 3}}).nearest(0, 4).empty());
  EXPECT_TRUE(tree.nearest(3, 0).empty());
}

TEST(Joined, IsTheUnion) {
  const std::vector<ImageIdPair> a{{ImageId{0}, ImageId{1}}, {ImageId{2}, ImageId{5}}},
      b{{ImageId{0}, ImageId{1}}, {ImageId{1}, ImageId{3}}};
  EXPECT_EQ(joined(a, b),
            (std::vector<ImageIdPair>{{ImageId{0}, ImageId{1}}, {ImageId{1}, ImageId{3}}, {ImageId{2}, ImageId{5}}}));
}

}  // namespace
}  // namespace collinea
