// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/foreground_fattening.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/math/random.h"

namespace collinea::dense {
namespace {

constexpr int kSide = 60, kEdge = 30;
constexpr float kReach = 0.1f;
const FloatImage kSigma(kSide, kSide, 1, 0.01f);

// What lies in front is seen left of kEdge; noise of 3 grey values.
GreyImage image_of(double front_grey, double behind_grey) {
  Random random(4);
  GreyImage image(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      image.at(x, y) = std::uint8_t(std::lround((x < kEdge ? front_grey : behind_grey) + 3 * random.normal()));
  return image;
}

// Its inverse depths, when the surface in front comes out to `edge`.
FloatImage step_at(int edge, float step = 1) {
  FloatImage surface(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) surface.at(x, y) = (x < edge ? 1 + step : 1) + 0.001f * float(x);
  return surface;
}

int empty_pixels(const FloatImage& surface, int from, int to) {
  int count = 0;
  for (int y = 0; y < surface.height; ++y)
    for (int x = from; x < to; ++x) count += std::isnan(surface.at(x, y));
  return count;
}

TEST(ForegroundFattening, WhatStandsOutOverAnEdgeGoesAndNothingElse) {
  for (const auto& [front, behind] : {std::pair(90.0, 160.0), std::pair(160.0, 90.0)}) {
    FloatImage surface = step_at(kEdge + 3);
    empty_foreground_fattening(image_of(front, behind), kReach, kSigma, surface, {});
    EXPECT_EQ(empty_pixels(surface, kEdge, kEdge + 3), 3 * kSide);
    EXPECT_EQ(empty_pixels(surface, 0, kEdge) + empty_pixels(surface, kEdge + 3, kSide), 0);
  }
}

TEST(ForegroundFattening, AnEdgeAtItsPositionStays) {
  FloatImage surface = step_at(kEdge);
  empty_foreground_fattening(image_of(90, 160), kReach, kSigma, surface, {});
  EXPECT_EQ(empty_pixels(surface, 0, kSide), 0);
}

TEST(ForegroundFattening, ASlopeIsNoEdge) {
  FloatImage surface = step_at(kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) surface.at(x, y) = 4 - 0.05f * float(x);
  empty_foreground_fattening(image_of(90, 160), kReach, kSigma, surface, {});
  EXPECT_EQ(empty_pixels(surface, 0, kSide), 0);
}

// A step of 0.25 that comes out too far is more than the reach of 0.1 and two sigmas of 0.07, and less than two of
// 0.08.
TEST(ForegroundFattening, WhatMayBeNoiseIsNoEdge) {
  for (const auto& [sigma, emptied] : {std::pair(0.07f, 3 * kSide), std::pair(0.08f, 0)}) {
    FloatImage surface = step_at(kEdge + 3, 0.25f);
    empty_foreground_fattening(image_of(90, 160), kReach, FloatImage(kSide, kSide, 1, sigma), surface, {});
    EXPECT_EQ(empty_pixels(surface, kEdge, kEdge + 3), emptied) << sigma;
    EXPECT_EQ(empty_pixels(surface, 0, kSide), emptied) << sigma;
  }
}

// Three pixels wide: nothing is surely in front.
TEST(ForegroundFattening, AThinPoleStays) {
  FloatImage surface = step_at(0);
  for (int y = 0; y < kSide; ++y)
    for (int x = kEdge; x < kEdge + 3; ++x) surface.at(x, y) = 2;
  const FloatImage before = surface;
  empty_foreground_fattening(image_of(90, 160), kReach, kSigma, surface, {});
  EXPECT_EQ(surface.data, before.data);
}

void expect_same(const FloatImage& surface, const FloatImage& expected) {
  ASSERT_EQ(surface.data.size(), expected.data.size());
  for (std::size_t i = 0; i < surface.data.size(); ++i)
    ASSERT_TRUE(surface.data[i] == expected.data[i] || (std::isnan(surface.data[i]) && std::isnan(expected.data[i])))
        << int(i) % kSide << ' ' << int(i) / kSide;
}

// Every third pixel of a column in front, on the fattened border and behind: their neighbours become what they were to
// be. Not in the outermost rows, where a pixel has only those of its own row to show an edge.
TEST(ForegroundFattening, EmptyPixelsChangeNothingAroundThem) {
  const GreyImage image = image_of(90, 160);
  FloatImage whole = step_at(kEdge + 3), holed = whole;
  const auto make_holes = [](FloatImage& surface) {
    for (const int x : {kEdge - 5, kEdge - 1, kEdge + 1, kEdge + 3, kEdge + 6})
      for (int y = 1; y + 1 < kSide; y += 3) surface.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  };
  make_holes(holed);
  empty_foreground_fattening(image, kReach, kSigma, holed, {});
  empty_foreground_fattening(image, kReach, kSigma, whole, {});
  EXPECT_EQ(empty_pixels(whole, 0, kSide), 3 * kSide);
  make_holes(whole);
  expect_same(holed, whole);
}

// Behind the fattened border almost all is empty: a pixel in fifteen rows is too little to judge by.
TEST(ForegroundFattening, EmptyPixelsAreNotBehind) {
  FloatImage surface = step_at(kEdge + 3);
  for (int y = 0; y < kSide; ++y)
    for (int x = kEdge + 3; x < kSide; ++x)
      if (x > kEdge + 3 || y % 15 != 7) surface.at(x, y) = std::numeric_limits<float>::quiet_NaN();
  const FloatImage before = surface;
  empty_foreground_fattening(image_of(90, 160), kReach, kSigma, surface, {});
  expect_same(surface, before);
}

// Greys so much alike that some pixels of the border go and some stay.
TEST(ForegroundFattening, ThreadsDoNotMatter) {
  const GreyImage image = image_of(120, 130);
  FloatImage surface = step_at(kEdge + 2), other = surface;
  collinea::Run one, four;
  one.threads = 1, four.threads = 4;
  empty_foreground_fattening(image, kReach, kSigma, surface, one);
  empty_foreground_fattening(image, kReach, kSigma, other, four);
  expect_same(other, surface);
  EXPECT_GT(empty_pixels(surface, 0, kSide), 0);
  EXPECT_LT(empty_pixels(surface, kEdge - 3, kEdge + 2), 5 * kSide);
}

}  // namespace
}  // namespace collinea::dense
