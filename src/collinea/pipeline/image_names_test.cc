// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/image_names.h"

#include <gtest/gtest.h>

namespace collinea {
namespace {

Block block_of(const std::vector<std::string>& files) {
  Block block;
  for (const std::string& file : files) block.images[ImageId{std::uint32_t(block.images.size())}].file = file;
  return block;
}

TEST(ImageNames, TheExactNameWinsAndAnyOtherLetterCaseMustBeUnique) {
  const ImageNames names(block_of({"A.JPG", "a.jpg", "b/C.jpg", "d/c.JPG", "e/F.jpg"}));
  EXPECT_EQ(names.find("A.JPG"), ImageId{0});
  EXPECT_EQ(names.find("a.jpg"), ImageId{1});
  EXPECT_EQ(names.find("a.JPG"), std::nullopt);
  EXPECT_EQ(names.find("C.jpg"), ImageId{2});
  EXPECT_EQ(names.find("D\\C.jpg"), ImageId{3});
  EXPECT_EQ(names.find("c.jpg"), std::nullopt);
  EXPECT_EQ(names.find("f.JPG"), ImageId{4});
  EXPECT_EQ(names.find("else/F.jpg"), ImageId{4});
}

TEST(ImageNames, APhotographIsFoundByTheEndOfItsPath) {
  const ImageNames names(block_of({"A.jpg", "b/A.jpg", "b/C.jpg"}));
  EXPECT_EQ(names.find_photo("/photos/A.jpg"), ImageId{0});
  EXPECT_EQ(names.find_photo("/photos/b/A.jpg"), ImageId{1});
  EXPECT_EQ(names.find_photo("b/./A.jpg"), ImageId{1});
  EXPECT_EQ(names.find_photo("A.jpg"), ImageId{0});
  EXPECT_EQ(names.find_photo("/A.jpg"), ImageId{0});
  EXPECT_EQ(names.find_photo("copies/c.JPG"), ImageId{2});
  EXPECT_EQ(names.find_photo("/photos/xA.jpg"), std::nullopt);
}

}  // namespace
}  // namespace collinea
