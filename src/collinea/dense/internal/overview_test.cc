// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/overview.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace collinea::dense {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

Camera small_camera() {
  Camera camera;
  camera.width_px = 60;
  camera.height_px = 40;
  camera.params[Camera::kF] = 60;
  camera.params[Camera::kCx] = 30;
  camera.params[Camera::kCy] = 20;
  return camera;
}

// A plane at `depth`, seen by a camera `aside` to the right of the reference.
LocatedMap plane_seen_from(double aside, float depth) {
  const Camera camera = small_camera();
  LocatedMap placed{{camera, FloatImage(camera.width_px, camera.height_px, 1, depth),
                     FloatImage(camera.width_px, camera.height_px, 1, 0.1f)},
                    {}};
  placed.reference_from_cam.translation = {aside, 0, 0};
  return placed;
}

TEST(AgreedSurface, IsTheNearestThatThreeImagesConfirm) {
  const DepthMap own = plane_seen_from(0, 20).map;  // alone with its opinion
  const std::vector<LocatedMap> others = {plane_seen_from(0.5, 10), plane_seen_from(-0.5, 10), plane_seen_from(0.3, 10),
                                          plane_seen_from(-0.3, 5)};
  const FloatImage agreed = agreed_surface(own, others, 0.002f);
  EXPECT_NEAR(agreed.at(30, 20), 0.1f, 1e-5f);
}

TEST(AgreedSurface, OneOtherImageIsEnoughForWhatTheImageItselfFound) {
  const DepthMap own = plane_seen_from(0, 10).map;
  EXPECT_NEAR(agreed_surface(own, {plane_seen_from(0.5, 10)}, 0.002f).at(30, 20), 0.1f, 1e-5f);
  EXPECT_TRUE(std::isnan(agreed_surface(own, {plane_seen_from(0.5, 20)}, 0.002f).at(30, 20)));
}

// Inverse depths; the reach is 0.002, three times that where nothing agrees so closely.
TEST(AgreedSurface, RoughSurfacesMayDifferByThreeTimesTheReach) {
  const DepthMap own = plane_seen_from(0, 1 / 0.1f).map;
  const LocatedMap same = plane_seen_from(0.5, 1 / 0.101f), rough = plane_seen_from(0.3, 1 / 0.105f),
                   other = plane_seen_from(0.3, 1 / 0.107f);
  EXPECT_NEAR(agreed_surface(own, {rough}, 0.002f).at(30, 20), 0.1025f, 1e-5f);
  EXPECT_TRUE(std::isnan(agreed_surface(own, {other}, 0.002f).at(30, 20)));
  EXPECT_NEAR(agreed_surface(own, {same, rough}, 0.002f).at(30, 20), 0.1005f, 1e-5f);  // the rough one does not count
}

TEST(AgreedSurface, IsEmptyWhereNobodyElseLooks) {
  const DepthMap own = plane_seen_from(0, 10).map;
  const FloatImage agreed = agreed_surface(own, {plane_seen_from(5, 10)}, 0.002f);  // shifted by half an image
  EXPECT_TRUE(std::isnan(agreed.at(10, 20)));
  EXPECT_FALSE(std::isnan(agreed.at(50, 20)));
}

// On the right half of the image a third image looks, which finds nothing; on the left half two say what they like.
TEST(AgreedSurface, WhatTwoImagesInventAtTheBorderGoes) {
  const auto with_a_patch = [](double aside, float depth) {  // before a plane at 10
    LocatedMap placed = plane_seen_from(aside, 10);
    for (int y = 10; y < 30; ++y)
      for (int x = 0; x < 20; ++x) placed.map.depth.at(x, y) = depth;
    return placed;
  };
  const auto on_patch = [&](float depth, const std::vector<LocatedMap>& more) {
    std::vector<LocatedMap> others(1, with_a_patch(0.001, depth));
    others.insert(others.end(), more.begin(), more.end());
    return agreed_surface(with_a_patch(0, depth).map, others, 0.002f).at(8, 20);
  };
  const std::vector<LocatedMap> third(1, plane_seen_from(5, 10));
  EXPECT_TRUE(std::isnan(on_patch(5, third)));
  EXPECT_NEAR(on_patch(7, third), 1 / 7.0, 1e-3);  // it may be a tree
  EXPECT_NEAR(on_patch(5, {}), 1 / 5.0, 1e-3);     // there are no more than two
}

TEST(FillRough, GivesTexturedHolesTheAgreedSurface) {
  GreyImage image(80, 40);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 80; ++x) image.at(x, y) = std::uint8_t(x < 40 ? 128 + 40 * ((x * 7 + y * 3) % 5 - 2) / 2 : 128);
  Level level;
  level.image = &image;
  level.step = 0.001f;
  const FloatImage empty(80, 40, 1, kNaN);
  Refined result{empty, empty, empty};
  result.inverse_depth.at(5, 5) = 0.2f;
  FloatImage agreed(20, 10, 1, 0.1f);
  for (int j = 0; j < 10; ++j) agreed.at(5, j) = kNaN;
  fill_rough(level, texture_centroid(image), agreed, result);
  EXPECT_FLOAT_EQ(result.inverse_depth.at(5, 5), 0.2f);  // measured: stays
  EXPECT_FLOAT_EQ(result.inverse_depth.at(10, 20), 0.1f);
  EXPECT_NEAR(result.sigma.at(10, 20), 0.4f * 4 * 0.001f, 1e-6f);
  EXPECT_TRUE(std::isnan(result.inverse_depth.at(22, 20)));  // the overviews do not agree
  EXPECT_TRUE(std::isnan(result.inverse_depth.at(41, 20)));  // texture beside it alone
  EXPECT_TRUE(std::isnan(result.inverse_depth.at(60, 20)));  // no texture
}

}  // namespace
}  // namespace collinea::dense
