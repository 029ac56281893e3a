// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/image_masks.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

using Ring = std::vector<Eigen::Vector2d>;

Ring rectangle(double left, double top, double right, double bottom) {
  return {{left, top}, {right, top}, {right, bottom}, {left, bottom}};
}

TEST(ImageMasks, HideWhatLiesInsideOfAnyRing) {
  MaskRings rings;
  EXPECT_TRUE(rings.empty());
  rings.add(rectangle(10, 10, 20, 20));
  rings.add({{100, 0}, {110, 10}, {100, 20}});  // a triangle
  int hidden = 0;
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 130; ++x) hidden += rings.hides({x + 0.5, y + 0.5});
  // The square has 100 centres of pixels; row y of the triangle has the centres with x + 0.5 < min(y, 20 - y) + 0.5.
  EXPECT_EQ(hidden, 100 + 2 * (0 + 1 + 2 + 3 + 4 + 5 + 6 + 7 + 8 + 9));
  EXPECT_FALSE(rings.hides({9.999, 15}));
  EXPECT_TRUE(rings.hides({10.001, 15}));
}

TEST(ImageMasks, OfAnImageHoldWithThoseOfAll) {
  ImageMasks masks;
  EXPECT_EQ(masks.of({3}), nullptr);
  masks.add(ImageId{3}, rectangle(0, 0, 10, 10));
  const std::string before = masks.text();
  masks.add(std::nullopt, rectangle(50, 50, 60, 60));
  masks.add(ImageId{4}, rectangle(0, 0, 20, 20));
  for (const std::uint32_t image : {3u, 4u, 5u}) {
    ASSERT_NE(masks.of({image}), nullptr);
    EXPECT_TRUE(masks.of({image})->hides({55, 55}));
    EXPECT_EQ(masks.of({image})->hides({15, 15}), image == 4);
    EXPECT_EQ(masks.of({image})->hides({5, 5}), image != 5);
  }
  EXPECT_NE(masks.text(), before);
}

}  // namespace
}  // namespace collinea
