// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/image_tiles.h"

#include <gtest/gtest.h>
#include <tiffio.h>

#include <cmath>
#include <cstdlib>
#include <thread>

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/codec.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/jpeg_reader.h"
#include "collinea/raster/pyramid.h"
#include "collinea/raster/tile_cache.h"

namespace collinea {
namespace {

// Smooth, with a different course in every channel.
Raster<std::uint8_t> image(int width, int height, int channels = 3) {
  Raster<std::uint8_t> raster(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        raster.at(x, y, c) = std::uint8_t(128 + 60 * std::sin(0.03 * x + c) + 60 * std::cos(0.02 * y * (c + 1)));
  return raster;
}

int largest_difference(const Raster<std::uint8_t>& a, const Raster<std::uint8_t>& b) {
  if (a.width != b.width || a.height != b.height || a.channels != b.channels) return 1000;
  int largest = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i)
    largest = std::max(largest, std::abs(int(a.data[i]) - int(b.data[i])));
  return largest;
}

double mean_difference(const Raster<std::uint8_t>& a, const Raster<std::uint8_t>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::abs(int(a.data[i]) - int(b.data[i]));
  return sum / double(a.data.size());
}

Raster<std::uint8_t> window_of(const Raster<std::uint8_t>& whole, const PixelWindow& w) {
  Raster<std::uint8_t> out(w.width, w.height, whole.channels);
  for (int y = 0; y < w.height; ++y)
    std::copy_n(whole.row(w.top + y) + w.left * whole.channels, w.width * whole.channels, out.row(y));
  return out;
}

// Every tile of every level against the whole image, reduced. What JPEG may change: the luma of these smooth images by
// 6 (a shift by a pixel changes that of reduced levels by twice as much), colours on the mean by 4, since each stands
// for four pixels.
void expect_tiles(const std::filesystem::path& file, const Raster<std::uint8_t>& whole, int channels) {
  const int levels = tile_levels(whole.width, whole.height);
  for (int level = 0; level < levels; ++level) {
    const TileLevels part = part_of_level(levels, level);
    const auto tiles = file.parent_path() / (part == TileLevels::kFine ? "fine" : "overview");
    ASSERT_TRUE(write_tiles(file, whole.width, whole.height, part, tiles));
    const Raster<std::uint8_t> reduced = shrunk(whole, 1 << (levels - 1 - level));
    for (int row = 0; row * kTilePx < reduced.height; ++row)
      for (int column = 0; column * kTilePx < reduced.width; ++column) {
        const auto tile = read_tile(tiles, whole.width, whole.height, {level, column, row});
        ASSERT_TRUE(tile) << tile.error().message;
        const PixelWindow window{column * kTilePx, row * kTilePx, std::min(kTilePx, reduced.width - column * kTilePx),
                                 std::min(kTilePx, reduced.height - row * kTilePx)};
        const auto decoded = decode_jpeg(*tile, channels, 1);
        ASSERT_TRUE(decoded);
        const auto wanted = with_channels(window_of(reduced, window), channels);
        EXPECT_LE(largest_difference(with_channels(*decoded, 1), with_channels(wanted, 1)), 6)
            << level << " " << column << " " << row;
        EXPECT_LE(mean_difference(*decoded, wanted), 4) << level << " " << column << " " << row;
      }
    EXPECT_FALSE(has_tile(whole.width, whole.height, {level, (reduced.width + 255) / 256, 0}));
    EXPECT_FALSE(has_tile(whole.width, whole.height, {level, 0, (reduced.height + 255) / 256}));
  }
}

TEST(ImageTiles, TheCoarsestLevelIsOneTile) {
  EXPECT_EQ(tile_levels(256, 1), 1);
  EXPECT_EQ(tile_levels(257, 100), 2);
  EXPECT_EQ(tile_levels(4000, 3000), 5);
  EXPECT_EQ(tile_levels(4096, 3000), 5);
  EXPECT_EQ(tile_levels(4097, 3000), 6);
  EXPECT_FALSE(has_tile(4000, 3000, {5, 0, 0}));
  EXPECT_FALSE(has_tile(4000, 3000, {-1, 0, 0}));
  EXPECT_FALSE(has_tile(4000, 3000, {0, 0, -1}));
  EXPECT_TRUE(has_tile(4000, 3000, {4, 15, 11}));
}

TEST(ImageTiles, ColourJpegIsTiled) {
  const TestFolder folder;
  for (const auto& [width, height] : {std::pair(1301, 1027), {1024, 512}, {300, 200}, {90, 40}}) {
    ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(width, height), 98));
    expect_tiles(folder / "a.jpg", read_colour(folder / "a.jpg").value(), 3);
  }
}

TEST(ImageTiles, GreyJpegGivesGreyTiles) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(1100, 700, 1), 98));
  expect_tiles(folder / "a.jpg", read_grey(folder / "a.jpg").value(), 1);
  ASSERT_TRUE(write_tiles(folder / "a.jpg", 1100, 700, TileLevels::kFine, folder / "fine"));
  EXPECT_EQ(jpeg_size(read_tile(folder / "fine", 1100, 700, {2, 0, 0}).value(), 1 << 20).value(), (Size{256, 256}));
}

TEST(ImageTiles, OtherFormatsAreTiled) {
  const TestFolder folder;
  ASSERT_TRUE(write_png(folder / "a.png", image(1030, 600)));
  expect_tiles(folder / "a.png", image(1030, 600), 3);
  TIFF* tiff = TIFFOpen((folder / "deep.tif").c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, 700);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, 500);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 16);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
  std::vector<std::uint16_t> row(700);
  for (int y = 0; y < 500; ++y) {
    for (int x = 0; x < 700; ++x) row[std::size_t(x)] = std::uint16_t(20000 + 8 * x + 11 * y);
    TIFFWriteScanline(tiff, row.data(), std::uint32_t(y), 0);
  }
  TIFFClose(tiff);
  expect_tiles(folder / "deep.tif", read_colour(folder / "deep.tif").value(), 3);
}

TEST(ImageTiles, WhatIsNoSuchImageIsAnError) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(600, 400), 90));
  const std::string bytes = read_file(folder / "a.jpg").value();
  ASSERT_TRUE(write_file(folder / "cut.jpg", bytes.substr(0, bytes.size() / 2)));
  ASSERT_TRUE(write_file(folder / "text.jpg", "no image"));
  const auto code = [&](const char* name, int width) {
    return write_tiles(folder / name, width, 400, TileLevels::kFine, folder / "tiles").error().code;
  };
  EXPECT_EQ(code("cut.jpg", 600), Errc::kBadFormat);
  EXPECT_EQ(code("text.jpg", 600), Errc::kBadFormat);
  EXPECT_EQ(code("a.jpg", 601), Errc::kBadFormat);
  EXPECT_EQ(code("missing.jpg", 600), Errc::kNotFound);
  EXPECT_FALSE(std::filesystem::exists(folder / "tiles"));
}

// Bytes of a kept file may be anything: a tile, or an error.
TEST(ImageTiles, DamagedFilesAreErrors) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(600, 400), 90));
  ASSERT_TRUE(write_tiles(folder / "a.jpg", 600, 400, TileLevels::kFine, folder / "tiles"));
  const std::string good = read_file(folder / "tiles").value();
  Random random(3);
  int errors = 0;
  for (int trial = 0; trial < 300; ++trial) {
    std::string bytes = good;
    for (int i = 0; i < 8; ++i) bytes[std::size_t(random.below(200))] = char(random.below(256));
    if (trial % 3 == 0) bytes.resize(random.below(bytes.size()));
    ASSERT_TRUE(write_file(folder / "odd", bytes));
    const auto tile = read_tile(folder / "odd", 600, 400, {1, 1, 0});
    if (tile) continue;
    EXPECT_EQ(tile.error().code, Errc::kBadFormat);
    ++errors;
  }
  EXPECT_GT(errors, 100);
  EXPECT_EQ(read_tile(folder / "tiles", 601, 400, {1, 1, 0}).error().code, Errc::kBadFormat);
  EXPECT_EQ(read_tile(folder / "none", 600, 400, {1, 1, 0}).error().code, Errc::kNotFound);
}

TEST(JpegReader, RowsAreThoseOfTheWholeImage) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(501, 303), 95));
  for (const int shrink : {1, 2, 4, 8}) {
    const ColourImage whole = read_colour(folder / "a.jpg", shrink).value();
    auto reader = JpegReader::open(folder / "a.jpg", shrink);
    ASSERT_TRUE(reader);
    EXPECT_EQ(reader->height(), whole.height);
    std::vector<std::uint8_t> rows;
    while (!reader->at_end()) {
      const auto some = reader->read(17);
      ASSERT_TRUE(some);
      rows.insert(rows.end(), some->data.begin(), some->data.end());
    }
    EXPECT_TRUE(rows == whole.data) << shrink;
  }
}

TEST(JpegReader, AWindowIsThatOfTheWholeImage) {
  const TestFolder folder;
  Random random(5);
  for (const int channels : {1, 3}) {
    Raster<std::uint8_t> noisy = image(501, 303, channels);
    for (std::uint8_t& value : noisy.data) value = std::uint8_t(std::clamp(value + int(random.below(61)) - 30, 0, 255));
    ASSERT_TRUE(write_jpeg(folder / "a.jpg", noisy, 95));
    const GreyImage whole = read_grey(folder / "a.jpg").value();
    for (const PixelWindow& window :
         {PixelWindow{0, 0, 501, 303}, {100, 90, 33, 41}, {470, 280, 31, 23}, {7, 0, 1, 1}}) {
      const auto part = read_jpeg_window(folder / "a.jpg", window);
      ASSERT_TRUE(part);
      EXPECT_TRUE(part->data == window_of(whole, window).data) << window.left;
    }
  }
}

class TileCacheTest : public ::testing::Test {
 protected:
  void SetUp() override { write("a.jpg", 90); }
  void write(const std::string& name, int quality) {
    ASSERT_TRUE(write_jpeg(folder_ / name, image(1301, 1027), quality));
  }
  [[nodiscard]] TiledImage tiled(const std::string& name = "a.jpg", std::uint32_t number = 1) const {
    return {folder_ / name, 1301, 1027, number};
  }
  [[nodiscard]] std::size_t files() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_ / "tiles")) ++count;
    return count;
  }
  TestFolder folder_;
};

TEST_F(TileCacheTest, WhatManyAskForIsMadeOnce) {
  TileCache cache;
  std::vector<Result<CachedTile>> answers(8, fail(Errc::kNotFound, ""));
  {
    std::vector<std::jthread> threads;
    for (auto& answer : answers)
      threads.emplace_back([&] { answer = cache.tile(folder_ / "tiles", tiled(), {3, 2, 1}); });
  }
  for (const auto& answer : answers) {
    ASSERT_TRUE(answer) << answer.error().message;
    EXPECT_TRUE(answer->jpeg == answers[0]->jpeg);
  }
  EXPECT_EQ(cache.made(), 1u);
  EXPECT_EQ(files(), 1u);
  ASSERT_TRUE(TileCache().tile(folder_ / "tiles", tiled(), {3, 2, 1}));  // another run of the program finds it
  EXPECT_EQ(files(), 1u);
}

TEST_F(TileCacheTest, AnImageThatChangesGetsOtherTiles) {
  TileCache cache;
  const auto before = cache.tile(folder_ / "tiles", tiled(), {0, 0, 0});
  write("a.jpg", 30);
  const auto after = cache.tile(folder_ / "tiles", tiled(), {0, 0, 0});
  ASSERT_TRUE(before && after);
  EXPECT_NE(before->tag, after->tag);
  EXPECT_EQ(cache.made(), 2u);
}

TEST_F(TileCacheTest, TheOldestGoWhereThereAreTooMany) {
  TileCache first;
  ASSERT_TRUE(first.tile(folder_ / "tiles", tiled(), {0, 0, 0}));
  const auto bytes = std::filesystem::file_size(std::filesystem::directory_iterator(folder_ / "tiles")->path());
  TileCache cache(2 * bytes + bytes / 2);
  for (std::uint32_t number = 2; number < 6; ++number)
    ASSERT_TRUE(cache.tile(folder_ / "tiles", tiled("a.jpg", number), {0, 0, 0}));
  EXPECT_EQ(files(), 2u);
  TileCache none(1);  // what is asked for is kept all the same
  ASSERT_TRUE(none.tile(folder_ / "tiles", tiled("a.jpg", 9), {0, 0, 0}));
  EXPECT_EQ(files(), 1u);
}

TEST_F(TileCacheTest, ABrokenImageIsNotTriedAgainUntilItChanges) {
  TileCache cache;
  const std::string bytes = read_file(folder_ / "a.jpg").value();
  ASSERT_TRUE(write_file(folder_ / "b.jpg", bytes.substr(0, bytes.size() / 3)));
  for (int i = 0; i < 3; ++i)
    EXPECT_EQ(cache.tile(folder_ / "tiles", tiled("b.jpg"), {0, 0, 0}).error().code, Errc::kBadFormat);
  EXPECT_EQ(cache.made(), 1u);
  ASSERT_TRUE(write_file(folder_ / "b.jpg", bytes));
  EXPECT_TRUE(cache.tile(folder_ / "tiles", tiled("b.jpg"), {0, 0, 0}));
  EXPECT_EQ(cache.tile(folder_ / "tiles", tiled("b.jpg"), {0, 1, 0}).error().code, Errc::kNotFound);
  EXPECT_EQ(cache.tile(folder_ / "tiles", tiled("c.jpg"), {0, 0, 0}).error().code, Errc::kNotFound);
}

TEST_F(TileCacheTest, ADamagedFileIsMadeAnew) {
  TileCache cache;
  const auto good = cache.tile(folder_ / "tiles", tiled(), {0, 0, 0});
  ASSERT_TRUE(good);
  ASSERT_TRUE(write_file(std::filesystem::directory_iterator(folder_ / "tiles")->path(), "nothing"));
  const auto again = cache.tile(folder_ / "tiles", tiled(), {0, 0, 0});
  ASSERT_TRUE(again);
  EXPECT_TRUE(again->jpeg == good->jpeg);
}

}  // namespace
}  // namespace collinea
