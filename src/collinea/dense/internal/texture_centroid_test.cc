// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/texture_centroid.h"

#include <gtest/gtest.h>

#include <cmath>

namespace collinea::dense {
namespace {

constexpr float kReach = 0.01f;

// A chequerboard of `contrast`.
GreyImage chequerboard(int contrast) {
  GreyImage image(40, 20);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) image.at(x, y) = std::uint8_t(128 + ((x + y) % 2 ? contrast : -contrast));
  return image;
}

TEST(TextureCentroid, IsTheMiddleOfEvenTextureAndTheEdgeOfAPlainImage) {
  const TextureCentroid even = texture_centroid(chequerboard(20));
  EXPECT_NEAR(even.right.at(20, 10), 0, 1e-6f);
  EXPECT_NEAR(even.down.at(20, 10), 0, 1e-6f);
  EXPECT_FALSE(even.is_aside(20, 10));

  GreyImage step(40, 20);  // from dark to bright between columns 19 and 20
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 40; ++x) step.at(x, y) = x < 20 ? 50 : 200;
  const TextureCentroid edge = texture_centroid(step);
  for (int x = 17; x < 23; ++x) EXPECT_NEAR(edge.right.at(x, 10), 19.5f - float(x), 1e-5f) << x;
  for (int x = 0; x < 40; ++x) EXPECT_EQ(edge.is_aside(x, 10), x < 18 || x > 21) << x;
}

TEST(TextureCentroid, WhereTheImageHasNothingIsNoTexture) {
  GreyImage half = chequerboard(20);
  for (int y = 0; y < 20; ++y)
    for (int x = 20; x < 40; ++x) half.at(x, y) = 0;
  EXPECT_FALSE(texture_centroid(half).is_aside(18, 10));
  EXPECT_TRUE(texture_centroid(half).is_aside(22, 10));
  EXPECT_TRUE(texture_centroid(GreyImage(1, 1)).is_aside(0, 0));
}

TEST(KeepTextured, ASurfaceEndsWhereItsTextureDoes) {
  GreyImage image = chequerboard(40);  // plain on the right
  for (int y = 0; y < 20; ++y)
    for (int x = 20; x < 40; ++x) image.at(x, y) = 128;
  FloatImage surface(40, 20, 1, 0.1f);
  keep_textured(texture_centroid(image), kReach, surface);
  for (int y = 3; y < 17; ++y)
    for (int x = 3; x < 40; ++x) EXPECT_EQ(std::isnan(surface.at(x, y)), x > 19) << x << " " << y;
}

// A bright stripe outshines the texture around it.
TEST(KeepTextured, GoesOnWhereTheSurfaceBeyondAgrees) {
  GreyImage image = chequerboard(2);
  for (int y = 0; y < 20; ++y) image.at(20, y) = 250;
  const TextureCentroid centroid = texture_centroid(image);
  ASSERT_TRUE(centroid.is_aside(23, 10));
  FloatImage plane(40, 20, 1, 0.1f);
  keep_textured(centroid, kReach, plane);
  for (int x = 3; x < 37; ++x) EXPECT_EQ(plane.at(x, 10), 0.1f) << x;

  FloatImage step(40, 20, 1, 0.1f);  // beyond column 24 something else
  for (int y = 0; y < 20; ++y)
    for (int x = 25; x < 40; ++x) step.at(x, y) = 0.2f;
  keep_textured(centroid, kReach, step);
  for (int x = 3; x < 37; ++x) EXPECT_EQ(std::isnan(step.at(x, 10)), x == 22 || x == 23) << x;
}

}  // namespace
}  // namespace collinea::dense
