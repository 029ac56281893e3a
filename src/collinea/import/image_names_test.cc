// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/image_names.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "collinea/base/test_folder.h"

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

TEST(ImageNames, AnImageIsFoundByTheEndOfItsPath) {
  const ImageNames names(block_of({"A.jpg", "b/A.jpg", "b/C.jpg", "d/E.jpg", "f/e.jpg"}));
  EXPECT_EQ(names.find_image("/photos/A.jpg"), ImageId{0});
  EXPECT_EQ(names.find_image("/photos/b/A.jpg"), ImageId{1});
  EXPECT_EQ(names.find_image("b/./A.jpg"), ImageId{1});
  EXPECT_EQ(names.find_image("A.jpg"), ImageId{0});
  EXPECT_EQ(names.find_image("/A.jpg"), ImageId{0});
  EXPECT_EQ(names.find_image("copies/c.JPG"), ImageId{2});
  const auto message = [&](const char* path) { return names.find_image(path).error().message; };
  EXPECT_EQ(message("/photos/xA.jpg"), "no photograph of the orientation is called xA.jpg");
  EXPECT_EQ(message("g/E.JPG"),
            "several photographs of the orientation are called E.JPG: give its path below the photo folder");
}

TEST(ImageNames, TheFileMeantIsThatOfTheWorkingFolder) {
  const TestFolder folder;
  std::filesystem::create_directory(folder / "b");
  std::ofstream(folder / "b" / "A.jpg") << "photo";
  const ImageNames names(block_of({"A.jpg", "b/A.jpg"}));
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder / "b");
  const auto found = names.find_image("A.jpg");
  std::filesystem::current_path(before);
  EXPECT_EQ(found, ImageId{1});
}

}  // namespace
}  // namespace collinea
