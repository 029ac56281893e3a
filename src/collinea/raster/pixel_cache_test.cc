// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/pixel_cache.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

TEST(PixelCache, DecodesOnceAndForgetsTheOldest) {
  int decoded = 0;
  PixelCache cache([&](ImageId, int) -> Result<ColourImage> { return ++decoded, ColourImage(10, 10, 3); }, 700);
  ASSERT_TRUE(cache.image_of(ImageId{1}, 1));
  ASSERT_TRUE(cache.image_of(ImageId{2}, 1));
  ASSERT_TRUE(cache.image_of(ImageId{1}, 1));
  EXPECT_EQ(decoded, 2);
  ASSERT_TRUE(cache.image_of(ImageId{3}, 1));  // 2 goes
  ASSERT_TRUE(cache.image_of(ImageId{1}, 1));
  EXPECT_EQ(decoded, 3);
  ASSERT_TRUE(cache.image_of(ImageId{2}, 1));
  EXPECT_EQ(decoded, 4);
}

TEST(PixelCache, KeepsNoMoreImagesThanItMayHoweverSmallTheyAre) {
  int decoded = 0;
  PixelCache cache([&](ImageId, int) -> Result<ColourImage> { return ++decoded, ColourImage(1, 1, 3); }, 700, 2);
  for (const std::uint32_t image : {1, 2, 3, 3, 2}) ASSERT_TRUE(cache.image_of(ImageId{image}, 1));
  EXPECT_EQ(decoded, 3);
  ASSERT_TRUE(cache.image_of(ImageId{1}, 1));  // 3 goes
  ASSERT_TRUE(cache.image_of(ImageId{2}, 1));
  EXPECT_EQ(decoded, 4);
}

TEST(PixelCache, PassesErrorsOn) {
  PixelCache cache([](ImageId, int) -> Result<ColourImage> { return fail(Errc::kNotFound, "gone"); }, 700);
  const auto image = cache.image_of(ImageId{1}, 1);
  ASSERT_FALSE(image);
  EXPECT_EQ(image.error().code, Errc::kNotFound);
}

}  // namespace
}  // namespace collinea
