// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/photo.h"

#include <gtest/gtest.h>

#include <cstdio>
// jpeglib.h needs <cstdio> before it.
#include <jpeglib.h>
#include <png.h>
#include <tiffio.h>

#include <array>
#include <cmath>
#include <cstring>
#include <thread>

#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/codec.h"

namespace collinea {
namespace {

// Smooth, with a different course in every channel.
Raster<std::uint8_t> picture(int width = 93, int height = 61, int channels = 3) {
  Raster<std::uint8_t> raster(width, height, channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c)
        raster.at(x, y, c) = std::uint8_t(128 + 60 * std::sin(0.08 * x + c) + 60 * std::cos(0.06 * y * (c + 1)));
  return raster;
}

double mean_difference(const Raster<std::uint8_t>& a, const Raster<std::uint8_t>& b) {
  if (a.data.size() != b.data.size()) return 1e9;
  double sum = 0;
  for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::abs(int(a.data[i]) - int(b.data[i]));
  return sum / double(a.data.size());
}

Raster<std::uint8_t> grey_of(const Raster<std::uint8_t>& colour) { return with_channels(colour, 1); }

TEST(Photo, JpegComesBackAlmostAsItWas) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(), 95));
  const ColourImage back = read_colour(folder / "a.jpg").value();
  EXPECT_EQ(back.width, 93);
  EXPECT_EQ(back.height, 61);
  EXPECT_LT(mean_difference(back, picture()), 2.0);
  EXPECT_LT(mean_difference(read_grey(folder / "a.jpg").value(), grey_of(picture())), 1.0);
}

TEST(Photo, ShrinkingKeepsTheCeilingOfTheSizeAndTheContent) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(), 98));
  ASSERT_TRUE(write_png(folder / "a.png", picture()));
  for (const int shrink : {2, 4, 8}) {
    const GreyImage jpeg = read_grey(folder / "a.jpg", shrink).value();
    const GreyImage png = read_grey(folder / "a.png", shrink).value();
    EXPECT_EQ(jpeg.width, (93 + shrink - 1) / shrink);
    EXPECT_EQ(jpeg.height, (61 + shrink - 1) / shrink);
    EXPECT_LT(mean_difference(jpeg, png), 3.0) << shrink;
    EXPECT_EQ(read_colour(folder / "a.jpg", shrink).value().width, jpeg.width);
  }
}

TEST(Photo, PngIsExactInOneThreeAndFourChannels) {
  const TestFolder folder;
  for (const int channels : {1, 3}) {
    ASSERT_TRUE(write_png(folder / "a.png", picture(50, 40, channels)));
    EXPECT_EQ((channels == 1 ? read_grey(folder / "a.png") : read_colour(folder / "a.png"))->data,
              picture(50, 40, channels).data);
  }
  ASSERT_TRUE(write_png(folder / "alpha.png", picture(50, 40, 4)));
  EXPECT_EQ(read_colour(folder / "alpha.png")->at(7, 9, 2), picture(50, 40, 4).at(7, 9, 2));
}

TEST(Photo, GreyFilesBecomeColourWithEqualChannels) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "grey.jpg", picture(40, 30, 1), 95));
  const ColourImage colour = read_colour(folder / "grey.jpg").value();
  ASSERT_EQ(colour.channels, 3);
  EXPECT_EQ(colour.at(5, 6, 0), colour.at(5, 6, 2));
}

struct TiffForm {
  std::uint16_t bits, samples, compression, photometric, predictor;
  bool tiled;
};

template <class T>
void write_tiff(const std::filesystem::path& path, const Raster<T>& raster, const TiffForm& form) {
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, raster.width);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, raster.height);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, form.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, form.samples);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, form.photometric);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, form.compression);
  if (form.predictor != 1) TIFFSetField(tiff, TIFFTAG_PREDICTOR, form.predictor);
  if (form.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 32);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16);
    for (int top = 0; top < raster.height; top += 16)
      for (int left = 0; left < raster.width; left += 32) {
        std::vector<T> tile(std::size_t(32 * 16 * raster.channels));
        for (int y = 0; y < std::min(16, raster.height - top); ++y)
          std::memcpy(&tile[std::size_t(y * 32 * raster.channels)], &raster.at(left, top + y),
                      std::size_t(std::min(32, raster.width - left) * raster.channels) * sizeof(T));
        TIFFWriteTile(tiff, tile.data(), std::uint32_t(left), std::uint32_t(top), 0, 0);
      }
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 7);
    for (int y = 0; y < raster.height; ++y) TIFFWriteScanline(tiff, const_cast<T*>(raster.row(y)), std::uint32_t(y), 0);
  }
  TIFFClose(tiff);
}

TEST(Photo, TiffIsExactInStripsAndTiles) {
  const TestFolder folder;
  for (const bool tiled : {false, true})
    for (const std::uint32_t compression : {1u, 5u})  // none, LZW
      expect_refused(folder / "b.tif", tiff_of({{256, 40000},
                                                {257, 20000},
                                                {258, 8},
                                                {259, compression},
                                                {262, 1},
                                                {273, 8},
                                                {277, 1},
                                                {278, 20000},
                                                {279, 100}}));
}

TEST(Photo, AnAbsurdTileOfASmallTiffIsRefusedBeforeMemoryIsTaken) {
  const TestFolder folder;
  ASSERT_TRUE(write_bytes(folder / "a.tif", small_tiff_with_large_tile(30000, 30000)));
  const auto picture = read_grey(folder / "a.tif");
  ASSERT_FALSE(picture);
  EXPECT_NE(picture.error().message.find("30000 x 30000 pixels cannot be in"), std::string::npos)
      << picture.error().message;
}

PhotoHeader full_header() {
  PhotoHeader header;
  header.maker = "DJI";
  header.model = "FC6310R";
  header.serial = "0K8TGB1234";
  header.lens = "8.8 mm";
  header.focal_mm = 8.8;
  header.focal_35mm_mm = 24;
  header.pixel_pitch_mm = 0.0024;
  header.taken = "2024:05:06 07:08:09.125";
  header.orientation = 1;
  header.latitude_deg = -33.912345678;
  header.longitude_deg = 151.123456789;
  header.height_m = 123.4567;
  header.sigma_east_m = 0.0123;
  header.sigma_north_m = 0.0145;
  header.sigma_height_m = 0.03;
  header.relative_height_m = 80.12;
  header.heading_deg = -123.4;
  header.pitch_deg = -89.9;
  header.roll_deg = 0.5;
  return header;
}

TEST(PhotoHeader, EverythingWrittenIsReadAgain) {
  const TestFolder folder;
  const PhotoHeader header = full_header();
  // Wide enough that the sensor is plausible for the pixel pitch.
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(5472, 8, 1), 50, &header));
  const PhotoHeader back = read_photo_header(folder / "a.jpg").value();
  EXPECT_EQ(back.width_px, 5472);
  EXPECT_EQ(back.height_px, 8);
  EXPECT_EQ(back.maker, header.maker);
  EXPECT_EQ(back.model, header.model);
  EXPECT_EQ(back.serial, header.serial);
  EXPECT_EQ(back.lens, header.lens);
  EXPECT_EQ(back.taken, header.taken);
  EXPECT_EQ(back.orientation, 1);
  EXPECT_NEAR(back.focal_mm.value(), 8.8, 1e-5);
  EXPECT_EQ(back.focal_35mm_mm.value(), 24);
  EXPECT_NEAR(back.pixel_pitch_mm.value(), 0.0024, 1e-9);
  EXPECT_NEAR(back.latitude_deg.value(), *header.latitude_deg, 1e-9);
  EXPECT_NEAR(back.longitude_deg.value(), *header.longitude_deg, 1e-9);
  EXPECT_NEAR(back.height_m.value(), *header.height_m, 1e-4);
  EXPECT_NEAR(back.sigma_east_m.value(), 0.0123, 1e-9);
  EXPECT_NEAR(back.sigma_north_m.value(), 0.0145, 1e-9);
  EXPECT_NEAR(back.sigma_height_m.value(), 0.03, 1e-9);
  EXPECT_NEAR(back.relative_height_m.value(), 80.12, 1e-9);
  EXPECT_NEAR(back.heading_deg.value(), -123.4, 1e-9);
  EXPECT_NEAR(back.pitch_deg.value(), -89.9, 1e-9);
  EXPECT_NEAR(back.roll_deg.value(), 0.5, 1e-9);
  EXPECT_TRUE(read_colour(folder / "a.jpg"));
}

TEST(PhotoHeader, BelowSeaLevelAndWestSurvive) {
  const TestFolder folder;
  PhotoHeader header;
  header.latitude_deg = 31.5;
  header.longitude_deg = -0.25;
  header.height_m = -420.5;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(), 90, &header));
  const PhotoHeader back = read_photo_header(folder / "a.jpg").value();
  EXPECT_NEAR(back.longitude_deg.value(), -0.25, 1e-9);
  EXPECT_NEAR(back.height_m.value(), -420.5, 1e-4);
}

TEST(PhotoHeader, ZeroZeroIsNoPlace) {
  const TestFolder folder;
  PhotoHeader header;
  header.latitude_deg = 0;
  header.longitude_deg = 0;
  header.height_m = 5;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(), 90, &header));
  const PhotoHeader back = read_photo_header(folder / "a.jpg").value();
  EXPECT_FALSE(back.latitude_deg || back.longitude_deg || back.height_m);
}

TEST(PhotoHeader, WithoutTagsNothingIsInvented) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(), 90));
  const PhotoHeader back = read_photo_header(folder / "a.jpg").value();
  EXPECT_EQ(back.width_px, 93);
  EXPECT_TRUE(back.maker.empty() && back.model.empty() && back.serial.empty() && back.taken.empty());
  EXPECT_FALSE(back.focal_mm || back.focal_35mm_mm || back.pixel_pitch_mm || back.latitude_deg || back.heading_deg);
  EXPECT_EQ(back.orientation, 1);
}

TEST(PhotoHeader, SeveralThreadsReadAtOnce) {
  const TestFolder folder;
  const PhotoHeader header = full_header();
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", picture(), 90, &header));
  std::array<int, 4> wrong{};
  {
    std::vector<std::jthread> threads;
    for (int& count : wrong)
      threads.emplace_back([&count, &folder] {
        for (int i = 0; i < 50; ++i) {
          const auto back = read_photo_header(folder / "a.jpg");
          count += !back || back->pitch_deg != -89.9 || back->model != "FC6310R";
        }
      });
  }
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

}  // namespace
}  // namespace collinea
