// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/import.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/block/world_frame.h"
#include "collinea/import/test_photographs.h"

namespace collinea {
namespace {

// Why a file was skipped: the code, what else it is about, figures and the words of whatever refused it.
std::string reason_for(const Imported& imported, const std::string& file) {
  for (const Finding& one : imported.skipped) {
    if (one.subjects.at(0).name != file) continue;
    std::string text(word_of(one.code));
    if (one.subjects.size() > 1) text += ", " + one.subjects[1].name;
    for (const Figure& figure : one.figures) text += fmt::format(", {} {:.0f}", word_of(figure.name), figure.value);
    return one.detail.empty() ? text : text + ": " + one.detail;
  }
  return "not skipped";
}

TEST(Import, OneCameraForImagesOfOneBodyLensAndSize) {
  const TestFolder folder;
  ImageHeader header = drone_header(), zoomed = header, other_body = header;
  zoomed.focal_mm = 20;
  zoomed.focal_35mm_mm = 55;
  other_body.serial = "2";
  put_image(folder / "1.jpg", &header);
  put_image(folder / "2.jpg", &header);
  put_image(folder / "3.jpg", &zoomed);
  put_image(folder / "4.jpg", &other_body);
  put_image(folder / "5.jpg", &header, 90, 120);  // turned, or another format: not the same pixels
  put_image(folder / "6.jpg", &header);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  std::vector<std::uint32_t> cameras;
  for (const auto& [id, image] : imported->block.images) cameras.push_back(image.camera.value);
  EXPECT_EQ(cameras, (std::vector<std::uint32_t>{0, 0, 1, 2, 3, 0}));
}

TEST(Import, BrokenDuplicateAndTinyFilesAreNamedAndTheRestGoesOn) {
  const TestFolder folder;
  const ImageHeader header = drone_header();
  put_image(folder / "a.jpg", &header);
  put_image(folder / "sub/b.jpg", &header);
  std::filesystem::copy_file(folder / "a.jpg", folder / "copy.jpg");
  put_image(folder / "tiny.jpg", &header, 40, 30);
  ASSERT_TRUE(write_file(folder / "text.jpg", "no image"));
  ASSERT_TRUE(write_file(folder / "empty.png", ""));
  ASSERT_TRUE(write_file(folder / "notes.txt", "not even called an image"));
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  ASSERT_EQ(imported->block.images.size(), 2u);
  EXPECT_EQ(imported->block.images.at(ImageId{0}).file, "a.jpg");
  EXPECT_EQ(imported->block.images.at(ImageId{1}).file, "sub/b.jpg");
  EXPECT_EQ(imported->file_hash.size(), 2u);
  EXPECT_EQ(imported->skipped.size(), 4u);
  EXPECT_EQ(reason_for(*imported, "copy.jpg"), "image_duplicate, a.jpg");
  EXPECT_EQ(reason_for(*imported, "empty.png"), "image_unreadable: is empty");
  EXPECT_EQ(reason_for(*imported, "text.jpg"), "image_unreadable: is neither JPEG, PNG nor TIFF");
  EXPECT_EQ(reason_for(*imported, "tiny.jpg"), "image_too_small, limit 64");
}

// The memory that a process may take, as `ulimit -v` sets it.
class MemoryLimit {
 public:
  explicit MemoryLimit(rlim_t bytes) {
    getrlimit(RLIMIT_AS, &before_);
    const rlimit limit{std::min(bytes, before_.rlim_max), before_.rlim_max};
    setrlimit(RLIMIT_AS, &limit);
  }
  ~MemoryLimit() { setrlimit(RLIMIT_AS, &before_); }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  rlimit before_{};
};

// Two megabytes that unpack to 40,000 x 40,000 pixels.
TEST(Import, AnImageThatNoMemoryHoldsIsLeftOutByItsSize) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "sanitizers take more memory than the limit of this test";
#endif
  const MemoryLimit limit(12'000'000'000);
  const TestFolder folder;
  const ImageHeader header = drone_header();
  put_image(folder / "a.jpg", &header);
  put_image(folder / "b.jpg", &header);
  constexpr std::string_view kHuge(
      "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x9c\x40\x00\x00\x9c\x40"
      "\x08\x00\x00\x00\x00\x74\x67\x51\xd9\x00\x00\x00\x08\x49\x44\x41\x54\x78\x9c\x03\x00\x00\x00\x00"
      "\x01\x48\x06\x89\xd2\x00\x00\x00\x00\x49\x45\x4e\x44\xae\x42\x60\x82",
      65);
  ASSERT_TRUE(write_file(folder / "huge.png", std::string(kHuge) + std::string(2'000'000, ' ')));
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_EQ(imported->block.images.size(), 2u);
  const std::string reason = reason_for(*imported, "huge.png");
  EXPECT_TRUE(
      reason.starts_with("image_unreadable: has 1600 megapixels (40000 x 40000): to make a map of it takes some 19 GB "
                         "of memory, and there are 12"))
      << reason;
}

TEST(Import, RastersOfAProjectAmongTheInputAreNotImported) {
  const TestFolder folder;
  for (const char* file : {"a.jpg", "b.jpg", "project/products/ortho.jpg", "products/ortho.jpg", "depth/1.jpg"})
    put_image(folder / file, nullptr);
  ASSERT_TRUE(write_file(folder / "project/block.db", "a project below"));
  const auto below = import_images(folder / "", {}, {});
  ASSERT_TRUE(below) << below.error().message;
  EXPECT_EQ(below->block.images.size(), 4u);  // products and depth here are the user's own
  ASSERT_TRUE(write_file(folder / "block.db", "a project in the folder itself"));
  const auto within = import_images(folder / "", {}, {});
  ASSERT_TRUE(within) << within.error().message;
  EXPECT_EQ(within->block.images.size(), 2u);
}

TEST(Import, FewerThanTwoImagesAreAnErrorThatSaysWhere) {
  const TestFolder folder;
  put_image(folder / "only.jpg", nullptr);
  for (const std::string& name : {std::string(), std::string("missing")}) {
    const auto imported = import_images(folder / name, {}, {});
    ASSERT_FALSE(imported);
    EXPECT_EQ(imported.error().code, Errc::kNotFound);
    EXPECT_NE(imported.error().message.find((folder / name).string()), std::string::npos) << imported.error().message;
  }
}

TEST(Import, PositionsGetTheUtmZoneAndStatedSigmasWin) {
  const TestFolder folder;
  const ImageHeader plain = header_at(48.2, 15.6);
  ImageHeader precise = header_at(48.2005, 15.6), flat = header_at(48.2, 15.6005);
  precise.sigma_east_m = 0.02;
  precise.sigma_north_m = 0.03;
  precise.sigma_height_m = 0.05;
  flat.height_m.reset();
  put_image(folder / "1.jpg", &plain);
  put_image(folder / "2.jpg", &precise);
  put_image(folder / "3.jpg", &flat);
  const auto imported = import_images(folder / "", {.gps_sigma_m = 3, .gps_sigma_height_m = 6}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  const Block& block = imported->block;
  ASSERT_TRUE(block.georeference);
  EXPECT_EQ(block.georeference->crs, "EPSG:32633");
  const auto& first = block.images.at(ImageId{0}).position.value();
  const auto& second = block.images.at(ImageId{1}).position.value();
  EXPECT_EQ(first.sigma_m, Eigen::Vector3d(3, 3, 6));
  EXPECT_EQ(second.sigma_m, Eigen::Vector3d(0.02, 0.03, 0.05));
  EXPECT_TRUE(std::isinf(block.images.at(ImageId{2}).position->sigma_m.z()));
  // 0.0005 degrees of latitude are 55.6 m of meridian here.
  EXPECT_NEAR(second.position_in_world.y() - first.position_in_world.y(), 55.6, 0.1);
}

TEST(Import, ImagesOnBothSidesOfTheDateLineAreBesideEachOther) {
  const TestFolder folder;
  const ImageHeader west = header_at(-17, 179.999), east = header_at(-17, -179.997);
  put_image(folder / "1.jpg", &west);
  put_image(folder / "2.jpg", &east);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  const Block& block = imported->block;
  EXPECT_EQ(block.georeference.value().crs, "EPSG:32701");
  EXPECT_NEAR(block.georeference->origin_longitude_deg, -179.999, 1e-9);
  for (const auto& [id, image] : block.images)
    EXPECT_LT(image.position->position_in_world.head<2>().norm(), 250) << image.file;
}

TEST(Import, AMapThatIsNoneIsAnErrorAlsoWhereNothingIsPlaced) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  const auto imported = import_images(folder / "", {.crs = "nonsense"}, {});
  ASSERT_FALSE(imported);
  EXPECT_EQ(imported.error().options, std::vector{"crs"_option});
}

TEST(Import, WithoutPositionsAndControlThereIsNoMap) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  put_image(folder / "b.jpg", nullptr);
  const auto imported = import_images(folder / "", {}, {});
  ASSERT_TRUE(imported) << imported.error().message;
  EXPECT_FALSE(imported->block.georeference);
}

TEST(SourcesFingerprint, ChangesWithImagesAndControlOnly) {
  const TestFolder folder;
  put_image(folder / "a.jpg", nullptr);
  ASSERT_TRUE(write_file(folder / "control.csv", kControl));
  const ImportOptions options{.control = (folder / "control.csv").string()};
  const std::string before = fingerprint_of_sources(folder / "", options);
  ASSERT_TRUE(write_file(folder / "notes.txt", "of no interest"));
  EXPECT_EQ(fingerprint_of_sources(folder / "", options), before);
  put_image(folder / "b.jpg", nullptr);
  const std::string more = fingerprint_of_sources(folder / "", options);
  EXPECT_NE(more, before);
  ASSERT_TRUE(write_file(folder / "control.csv", kControl + "image, A, a.jpg, 1, 2\n"));
  EXPECT_NE(fingerprint_of_sources(folder / "", options), more);
}

}  // namespace
}  // namespace collinea
