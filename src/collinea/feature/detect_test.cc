// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/detect.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "collinea/math/random.h"

namespace collinea {
namespace {

// Rectangles of many sizes and greys over each other: corners everywhere. Every pixel is the mean of 4 x 4 samples.
GreyImage rectangles(int width, int height, double shift_px, std::uint64_t seed) {
  struct Box {
    double x, y, w, h;
    int grey;
  };
  Random random(seed);
  std::vector<Box> boxes;
  for (int i = 0; i < 240; ++i) {
    const double w = 8 + 60.0 * random.uniform(), h = 8 + 60.0 * random.uniform();
    boxes.push_back({random.uniform() * width - w / 2 + shift_px, random.uniform() * height - h / 2 + shift_px, w, h,
                     int(30 + random.below(200))});
  }
  GreyImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      int sum = 0;
      for (int s = 0; s < 16; ++s) {
        const double u = x + (s % 4 + 0.5) / 4, v = y + (s / 4 + 0.5) / 4;
        int grey = 20;
        for (const Box& b : boxes)
          if (u >= b.x && u < b.x + b.w && v >= b.y && v < b.y + b.h) grey = b.grey;
        sum += grey;
      }
      image.at(x, y) = static_cast<std::uint8_t>((sum + 8) / 16);
    }
  return image;
}

int distance2(const Descriptor& a, const Descriptor& b) {
  int sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

class Corners : public testing::TestWithParam<Detector> {};

TEST_P(Corners, AreFoundAndMatchedAgainWhereTheImageIsShifted) {
  constexpr double kShift_px = 5.25;
  const DetectOptions options{.detector = GetParam(), .sift = {.max_features = 1500}};
  const Features a = detect_features(rectangles(256, 200, 0, 3), options);
  const Features b = detect_features(rectangles(256, 200, kShift_px, 3), options);
  ASSERT_GT(a.keypoints.size(), 100u);
  int matched = 0, right = 0, fine = 0;
  double dx = 0;
  for (std::size_t i = 0; i < a.keypoints.size(); ++i) {
    int best = 1 << 30, second = 1 << 30;
    std::size_t which = 0;
    for (std::size_t j = 0; j < b.keypoints.size(); ++j) {
      const int d = distance2(a.descriptors[i], b.descriptors[j]);
      if (d < best) {
        second = best;
        best = d;
        which = j;
      } else if (d < second) {
        second = d;
      }
    }
    if (best > 0.64 * second) continue;
    ++matched;
    const double x = b.keypoints[which].x - a.keypoints[i].x, y = b.keypoints[which].y - a.keypoints[i].y;
    if (std::hypot(x - kShift_px, y - kShift_px) > 0.6 * a.keypoints[i].scale_px) continue;  // 1.5 px of its level
    ++right;
    if (a.keypoints[i].scale_px > 3) continue;
    ++fine;
    dx += x;
  }
  EXPECT_GT(matched, static_cast<int>(a.keypoints.size()) / 3);
  EXPECT_GT(right, 0.95 * matched);
  ASSERT_GT(fine, 20);
  EXPECT_NEAR(dx / fine, kShift_px, 0.05);
}

TEST_P(Corners, ComeFromEveryLevelUnlessOneIsAskedFor) {
  const GreyImage image = rectangles(256, 200, 0, 4);
  const auto scales = [&](int levels) {
    std::set<float> out;
    for (const Keypoint& k :
         detect_features(image, {.detector = GetParam(), .corner_levels = levels, .sift = {}}).keypoints)
      out.insert(k.scale_px);
    return out;
  };
  EXPECT_EQ(scales(1).size(), 1u);
  const std::set<float> all = scales(3);
  ASSERT_EQ(all.size(), 3u);
  EXPECT_FLOAT_EQ(*all.rbegin(), 4 * *all.begin());
}

TEST_P(Corners, AreAsManyAsAskedForAndTheStrongestStandFirst) {
  const GreyImage image = rectangles(256, 200, 0, 5);
  for (const int most : {1, 10, 100}) {
    const Features found = detect_features(image, {.detector = GetParam(), .sift = {.max_features = most}});
    EXPECT_EQ(found.keypoints.size(), std::size_t(most));
    EXPECT_EQ(found.descriptors.size(), found.keypoints.size());
    EXPECT_TRUE(std::ranges::is_sorted(found.keypoints, std::ranges::greater{}, &Keypoint::strength));
  }
}

TEST_P(Corners, OfAnImageWithoutAnyAreNone) {
  const DetectOptions options{.detector = GetParam(), .sift = {}};
  EXPECT_TRUE(detect_features(GreyImage(100, 100, 1, 90), options).keypoints.empty());
  EXPECT_TRUE(detect_features(GreyImage(20, 100, 1, 90), options).keypoints.empty());
  EXPECT_TRUE(detect_features(GreyImage(), options).keypoints.empty());
}

INSTANTIATE_TEST_SUITE_P(Detectors, Corners, testing::Values(Detector::kHarris, Detector::kFoerstner));

TEST(DetectFeatures, AreThoseOfSiftUnlessSaidOtherwise) {
  const GreyImage image = rectangles(160, 120, 0, 6);
  const Features one = detect_sift(image, {}), other = detect_features(image, {});
  ASSERT_EQ(one.keypoints.size(), other.keypoints.size());
  EXPECT_EQ(one.descriptors, other.descriptors);
  for (std::size_t i = 0; i < one.keypoints.size(); ++i) {
    EXPECT_EQ(one.keypoints[i].x, other.keypoints[i].x);
    EXPECT_EQ(one.keypoints[i].strength, other.keypoints[i].strength);
  }
}

}  // namespace
}  // namespace collinea
