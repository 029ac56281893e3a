// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/random.h"

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

TEST(SelectPairs, FewImagesAreMatchedAllWithAll) {
  const auto pairs = select_pairs(sequence(20), {});
  EXPECT_EQ(pairs.size(), 190u);
  expect_sorted_and_once(pairs);
  EXPECT_TRUE(images_to_preselect(sequence(20), {}).empty());
  EXPECT_TRUE(select_pairs({}, {}).empty());
  EXPECT_TRUE(select_pairs(sequence(1), {}).empty());
}

TEST(SelectPairs, NeighboursInSpaceArePairsAndFarOnesAreNot) {
  const std::uint32_t per_strip = 20;
  const Block block = strips(8, per_strip);
  const auto pairs = select_pairs(block, {});
  expect_sorted_and_once(pairs);
  for (std::uint32_t strip = 0; strip + 1 < 8; ++strip)
    for (std::uint32_t i = 0; i < per_strip; ++i) {
      const std::uint32_t here = strip * per_strip + i, beside = (strip + 1) * per_strip + (per_strip - 1 - i);
      EXPECT_TRUE(has(pairs, here, beside)) << here << " " << beside;
    }
  for (const auto& [a, b] : pairs) {
    const double distance_m =
        (block.images.at(a).position->position_in_world - block.images.at(b).position->position_in_world).norm();
    EXPECT_LT(distance_m, 130);
  }
  EXPECT_LT(pairs.size(), block.images.size() * 16);
  EXPECT_TRUE(images_to_preselect(block, {}).empty());
}

// With 3 m between exposures the twelve nearest all lie in the same strip.
TEST(SelectPairs, StripsBesideAreFoundEvenWhenTheStripItselfIsDense) {
  const std::uint32_t per_strip = 60;
  PairOptions options;
  options.sequence_overlap = 0;
  const auto pairs = select_pairs(strips(3, per_strip, 40, 3), options);
  int without = 0;
  for (std::uint32_t i = 0; i < per_strip; ++i) {
    bool any = false;
    for (std::uint32_t j = per_strip; j < 2 * per_strip; ++j) any = any || has(pairs, i, j);
    without += !any;
  }
  EXPECT_EQ(without, 0);
}

TEST(SelectPairs, AFlyingHeightAddsThePairsWhoseFootprintsOverlap) {
  const Block block = strips(6, 20);
  PairOptions options;
  options.neighbours = 8;
  const auto without = select_pairs(block, options);
  options.height_above_ground_m = 60;  // footprint 80 m x 60 m: up to 42 m apart
  const auto pairs = select_pairs(block, options);
  for (const auto& [a, one] : block.images)
    for (const auto& [b, other] : block.images)
      if (a < b && (one.position->position_in_world - other.position->position_in_world).norm() < 42) {
        EXPECT_TRUE(has(pairs, a.value, b.value));
      }
  EXPECT_GT(pairs.size(), without.size());
}

TEST(SelectPairs, WithoutPositionsTheOrderOfTakingCountsAndNumbersCountAsNumbers) {
  Block block = sequence(120);  // IMG_0 ... IMG_119: as text, IMG_10 would follow IMG_1
  const auto pairs = select_pairs(block, {});
  expect_sorted_and_once(pairs);
  for (std::uint32_t i = 0; i + 6 < 120; ++i)
    for (std::uint32_t step = 1; step <= 6; ++step) EXPECT_TRUE(has(pairs, i, i + step));
  EXPECT_FALSE(has(pairs, 10, 17));
  EXPECT_TRUE(has(pairs, 10, 10 + 96));
  EXPECT_EQ(images_to_preselect(block, {}).size(), 120u);

  // Times win over names, when all images have one.
  for (auto& [id, image] : block.images)
    image.taken = "2024:05:01 10:" + std::to_string(10 + (id.value * 7) % 120 / 2) + ":" +
                  std::to_string(10 + (id.value * 7) % 2 * 30);
  const auto timed = select_pairs(block, {});
  EXPECT_TRUE(has(timed, 0, 103));  // 103 * 7 = 721 = 1 (mod 120)
  EXPECT_FALSE(has(timed, 0, 1));
  block.images[ImageId{3}].taken.clear();
  EXPECT_EQ(select_pairs(block, {}), pairs);
}

TEST(SelectPairs, ManyImagesAtOnePlaceDoNotBecomeAllWithAll) {
  Block block = sequence(400);
  for (auto& [id, image] : block.images) image.position = PositionPrior{{0, 0, 0}, {5, 5, 10}};
  EXPECT_LT(select_pairs(block, {}).size(), 400u * 24);
}

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
};

TEST(PreselectPairs, ImagesThatShowTheSameAreFound) {
  const auto images = Library::images();
  collinea::Run run;
  PreselectOptions options;
  options.features = 40;
  const auto pairs = preselect_pairs(images, images, Library::features, options, run);
  ASSERT_TRUE(pairs);
  expect_sorted_and_once(*pairs);
  EXPECT_EQ(pairs->size(), std::size_t{Library::kGroups * 10});
  for (const auto& [a, b] : *pairs) EXPECT_EQ(a.value % Library::kGroups, b.value % Library::kGroups);
  run.threads = 3;
  EXPECT_EQ(preselect_pairs(images, images, Library::features, options, run).value(), *pairs);
}

TEST(PreselectPairs, OnlyTheWantedImagesGetPartnersAndNotMoreThanAskedFor) {
  const auto images = Library::images();
  PreselectOptions options;
  options.features = 40;
  options.partners = 2;
  const std::vector wanted{ImageId{4}, ImageId{20}};
  const auto pairs = preselect_pairs(wanted, images, Library::features, options, {});
  ASSERT_TRUE(pairs);
  EXPECT_EQ(pairs->size(), 4u);
  for (const auto& [a, b] : *pairs) EXPECT_TRUE(a == wanted[0] || b == wanted[0] || a == wanted[1] || b == wanted[1]);
}

TEST(PreselectPairs, ErrorsAndStopsArePassedOn) {
  const auto images = Library::images();
  const auto broken = [](ImageId image) -> Result<Features> {
    if (image.value == 7) return fail(Errc::kNotFound, "no features");
    return Features{};
  };
  const auto failed = preselect_pairs(images, images, broken, {}, {});
  ASSERT_FALSE(failed);
  EXPECT_EQ(failed.error().code, Errc::kNotFound);

  std::stop_source source;
  source.request_stop();
  collinea::Run run;
  run.stop = source.get_token();
  const auto stopped = preselect_pairs(images, images, Library::features, {}, run);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, Errc::kCancelled);
}

TEST(Joined, IsTheUnion) {
  const std::vector<ImageIdPair> a{{ImageId{0}, ImageId{1}}, {ImageId{2}, ImageId{5}}},
      b{{ImageId{0}, ImageId{1}}, {ImageId{1}, ImageId{3}}};
  EXPECT_EQ(joined(a, b),
            (std::vector<ImageIdPair>{{ImageId{0}, ImageId{1}}, {ImageId{1}, ImageId{3}}, {ImageId{2}, ImageId{5}}}));
}

}  // namespace
}  // namespace collinea
