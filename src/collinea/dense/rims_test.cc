// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/rims.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/base/random.h"

namespace collinea::dense {
namespace {

constexpr int kSide = 60, kEdge = 30;
constexpr float kReach = 0.1f;
const FloatImage kSigma(kSide, kSide, 1, 0.01f);

// What lies in front is seen left of kEdge; noise of 3 grey values.
GreyImage picture_of(double front_grey, double behind_grey) {
  Random random(4);
  GreyImage picture(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x)
      picture.at(x, y) = std::uint8_t(std::lround((x < kEdge ? front_grey : behind_grey) + 3 * random.normal()));
  return picture;
}

// Its inverse depths, when the surface in front comes out to `edge`.
FloatImage step_at(int edge) {
  FloatImage surface(kSide, kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) surface.at(x, y) = (x < edge ? 2.0f : 1.0f) + 0.001f * float(x);
  return surface;
}

int empty_pixels(const FloatImage& surface, int from, int to) {
  int count = 0;
  for (int y = 0; y < surface.height; ++y)
    for (int x = from; x < to; ++x) count += std::isnan(surface.at(x, y));
  return count;
}

TEST(Rims, WhatStandsOutOverAnEdgeGoesAndNothingElse) {
  for (const auto& [front, behind] : {std::pair(90.0, 160.0), std::pair(160.0, 90.0)}) {
    FloatImage surface = step_at(kEdge + 3);
    empty_false_rims(picture_of(front, behind), kReach, kSigma, surface, {});
    EXPECT_EQ(empty_pixels(surface, kEdge, kEdge + 3), 3 * kSide);
    EXPECT_EQ(empty_pixels(surface, 0, kEdge) + empty_pixels(surface, kEdge + 3, kSide), 0);
  }
}

TEST(Rims, AnEdgeAtItsPlaceStays) {
  FloatImage surface = step_at(kEdge);
  empty_false_rims(picture_of(90, 160), kReach, kSigma, surface, {});
  EXPECT_EQ(empty_pixels(surface, 0, kSide), 0);
}

TEST(Rims, ASlopeIsNoEdge) {
  FloatImage surface = step_at(kSide);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) surface.at(x, y) = 4 - 0.05f * float(x);
  empty_false_rims(picture_of(90, 160), kReach, kSigma, surface, {});
  EXPECT_EQ(empty_pixels(surface, 0, kSide), 0);
}

TEST(Rims, NoiseIsNoEdge) {
  FloatImage surface(kSide, kSide, 1, 1.0f);
  Random random(8);
  for (float& w : surface.data) w += 0.2f * float(random.uniform(-1, 1));
  empty_false_rims(picture_of(90, 160), kReach, FloatImage(kSide, kSide, 1, 0.4f), surface, {});
  EXPECT_EQ(empty_pixels(surface, 0, kSide), 0);
}

// Three pixels wide: nothing is surely in front.
TEST(Rims, AThinPoleStays) {
  FloatImage surface = step_at(0);
  for (int y = 0; y < kSide; ++y)
    for (int x = kEdge; x < kEdge + 3; ++x) surface.at(x, y) = 2;
  const FloatImage before = surface;
  empty_false_rims(picture_of(90, 160), kReach, kSigma, surface, {});
  EXPECT_EQ(surface.data, before.data);
}

TEST(Rims, EmptyPixelsAndThreadsChangeNothing) {
  const GreyImage picture = picture_of(120, 130);
  FloatImage surface = step_at(kEdge + 2);
  for (int y = 0; y < kSide; y += 3) surface.at(kEdge - 5, y) = std::numeric_limits<float>::quiet_NaN();
  FloatImage other = surface;
  collinea::Run one, four;
  one.threads = 1, four.threads = 4;
  empty_false_rims(picture, kReach, kSigma, surface, one);
  empty_false_rims(picture, kReach, kSigma, other, four);
  for (std::size_t i = 0; i < surface.data.size(); ++i)
    ASSERT_TRUE(surface.data[i] == other.data[i] || (std::isnan(surface.data[i]) && std::isnan(other.data[i]))) << i;
  EXPECT_GT(empty_pixels(surface, kEdge, kEdge + 2), 0);
}

}  // namespace
}  // namespace collinea::dense
