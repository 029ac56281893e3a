// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/image_file.h"
#include "collinea/raster/jpeg_writer.h"

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

#include "collinea/base/file.h"
#include "collinea/base/test_folder.h"
#include "collinea/math/random.h"
#include "collinea/raster/codec.h"

namespace collinea {
namespace {

// Smooth, with a different course in every channel.
Raster<std::uint8_t> image(int width = 93, int height = 61, int channels = 3) {
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

TEST(ImageFile, JpegComesBackAlmostAsItWas) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 95));
  const ColourImage back = read_colour(folder / "a.jpg").value();
  EXPECT_EQ(back.width, 93);
  EXPECT_EQ(back.height, 61);
  EXPECT_LT(mean_difference(back, image()), 2.0);
  EXPECT_LT(mean_difference(read_grey(folder / "a.jpg").value(), grey_of(image())), 1.0);
}

TEST(ImageFile, JpegByRowsHasTheSameBytes) {
  const TestFolder folder;
  for (const int channels : {1, 3}) {
    const Raster<std::uint8_t> whole = image(1500, 700, channels);  // more bytes than are handed on at once
    ASSERT_TRUE(write_jpeg(folder / "whole.jpg", whole, 98));
    auto writer = JpegWriter::create(folder / "rows.jpg", whole.width, whole.height, channels, 98);
    ASSERT_TRUE(writer) << writer.error().message;
    for (int begin = 0; begin < whole.height; begin += 93) {
      Raster<std::uint8_t> rows(whole.width, std::min(93, whole.height - begin), channels);
      std::copy_n(whole.row(begin), rows.data.size(), rows.data.begin());
      ASSERT_TRUE(writer->write(rows));
    }
    EXPECT_EQ(is_there(folder / "rows.jpg"), channels == 3);  // that of the first
    ASSERT_TRUE(writer->finish());
    EXPECT_EQ(read_bytes(folder / "rows.jpg").value(), read_bytes(folder / "whole.jpg").value());
  }
  // Rows that never came: no file.
  { ASSERT_TRUE(JpegWriter::create(folder / "none.jpg", 10, 10, 1, 90)); }
  auto writer = JpegWriter::create(folder / "none.jpg", 10, 10, 1, 90);
  ASSERT_TRUE(writer);
  EXPECT_FALSE(writer->finish());
  EXPECT_FALSE(JpegWriter::create(folder / "none.jpg", 70'000, 10, 1, 90));
}

TEST(ImageFile, ShrinkingKeepsTheCeilingOfTheSizeAndTheContent) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 98));
  ASSERT_TRUE(write_png(folder / "a.png", image()));
  for (const int shrink : {2, 4, 8}) {
    const GreyImage jpeg = read_grey(folder / "a.jpg", shrink).value();
    const GreyImage png = read_grey(folder / "a.png", shrink).value();
    EXPECT_EQ(jpeg.width, (93 + shrink - 1) / shrink);
    EXPECT_EQ(jpeg.height, (61 + shrink - 1) / shrink);
    EXPECT_LT(mean_difference(jpeg, png), 3.0) << shrink;
    EXPECT_EQ(read_colour(folder / "a.jpg", shrink).value().width, jpeg.width);
  }
}

TEST(ImageFile, PngIsExactInOneThreeAndFourChannels) {
  const TestFolder folder;
  for (const int channels : {1, 3}) {
    ASSERT_TRUE(write_png(folder / "a.png", image(50, 40, channels)));
    EXPECT_EQ((channels == 1 ? read_grey(folder / "a.png") : read_colour(folder / "a.png"))->data,
              image(50, 40, channels).data);
  }
  ASSERT_TRUE(write_png(folder / "alpha.png", image(50, 40, 4)));
  EXPECT_EQ(read_colour(folder / "alpha.png")->at(7, 9, 2), image(50, 40, 4).at(7, 9, 2));
}

TEST(ImageFile, GreyFilesBecomeColourWithEqualChannels) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "grey.jpg", image(40, 30, 1), 95));
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

TEST(ImageFile, TiffIsExactInStripsAndTiles) {
  const TestFolder folder;
  for (const bool tiled : {false, true})
    for (const std::uint16_t compression : {COMPRESSION_NONE, COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE}) {
      const std::uint16_t predictor = compression == COMPRESSION_NONE ? 1 : 2;
      write_tiff(folder / "c.tif", image(70, 45), {8, 3, compression, PHOTOMETRIC_RGB, predictor, tiled});
      EXPECT_EQ(read_colour(folder / "c.tif").value().data, image(70, 45).data);
      write_tiff(folder / "g.tif", image(70, 45, 1), {8, 1, compression, PHOTOMETRIC_MINISBLACK, predictor, tiled});
      EXPECT_EQ(read_grey(folder / "g.tif").value().data, image(70, 45, 1).data);
    }
}

TEST(ImageFile, InvertedTiffGoesThroughTheConversion) {
  const TestFolder folder;
  write_tiff(folder / "i.tif", image(70, 45, 1), {8, 1, COMPRESSION_NONE, PHOTOMETRIC_MINISWHITE, 1, false});
  const GreyImage back = read_grey(folder / "i.tif").value();
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(69, 0), std::pair(3, 44)})
    EXPECT_EQ(back.at(x, y), 255 - image(70, 45, 1).at(x, y));
}

// 1000 samples of a ramp 10000 .. 10999: the 0.1 and 99.9 percentiles are its second value and its last.
TEST(ImageFile, SixteenBitsAreStretchedBetweenTheirPercentiles) {
  const TestFolder folder;
  Raster<std::uint16_t> ramp(1000, 1);
  for (int x = 0; x < 1000; ++x) ramp.at(x, 0) = std::uint16_t(10000 + x);
  write_tiff(folder / "r.tif", ramp, {16, 1, COMPRESSION_NONE, PHOTOMETRIC_MINISBLACK, 1, false});
  const GreyImage back = read_grey(folder / "r.tif").value();
  EXPECT_EQ(back.at(0, 0), 0);
  EXPECT_EQ(back.at(1, 0), 0);
  EXPECT_EQ(back.at(999, 0), 255);
  EXPECT_NEAR(back.at(500, 0), 255.0 * 499 / 998, 0.51);
}

TEST(ImageFile, SixteenBitPngIsReadInTheRightByteOrder) {
  const TestFolder folder;
  std::FILE* file = std::fopen((folder / "r.png").c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, file);
  png_set_IHDR(png, info, 600, 1, 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, 0, 0);
  png_write_info(png, info);
  std::vector<png_byte> row;
  for (int x = 0; x < 600; ++x) row.insert(row.end(), {png_byte(x >> 8), png_byte(x & 255)});
  png_write_row(png, row.data());
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(file);
  const GreyImage back = read_grey(folder / "r.png").value();
  for (int x = 1; x < 600; ++x) EXPECT_GE(back.at(x, 0), back.at(x - 1, 0));
  EXPECT_EQ(back.at(599, 0), 255);
}

// Rows come in seven passes; of 16 bits the file is read twice. 150 rows are more than are unpacked at once.
TEST(ImageFile, PngInPassesIsWhatItIsInRows) {
  const TestFolder folder;
  for (const int bits : {8, 16}) {
    for (const int passes : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
      std::FILE* file = std::fopen((folder / (std::to_string(passes) + ".png")).c_str(), "wb");
      png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
      png_infop info = png_create_info_struct(png);
      png_init_io(png, file);
      png_set_IHDR(png, info, 70, 150, bits, PNG_COLOR_TYPE_RGB_ALPHA, passes, 0, 0);
      png_write_info(png, info);
      std::vector<std::vector<png_byte>> rows(150);
      std::vector<png_bytep> pointers;
      for (int y = 0; y < 150; ++y) {
        for (int i = 0; i < 70 * 4 * bits / 8; ++i) rows[std::size_t(y)].push_back(png_byte(i * 7 + y * 3));
        pointers.push_back(rows[std::size_t(y)].data());
      }
      png_write_image(png, pointers.data());
      png_write_end(png, nullptr);
      png_destroy_write_struct(&png, &info);
      std::fclose(file);
    }
    for (const bool is_grey : {true, false}) {
      const auto read = [&](int passes) {
        const auto path = folder / (std::to_string(passes) + ".png");
        return is_grey ? read_grey(path).value() : read_colour(path).value();
      };
      const auto in_rows = read(PNG_INTERLACE_NONE), in_passes = read(PNG_INTERLACE_ADAM7);
      ASSERT_EQ(in_rows.height, 150);
      ASSERT_EQ(in_rows.channels, is_grey ? 1 : 3);
      EXPECT_EQ(in_rows.data, in_passes.data);
      if (bits == 8 && !is_grey) {
        EXPECT_EQ(in_rows.at(2, 149, 1), std::uint8_t(9 * 7 + 149 * 3));
      }
    }
  }
}

// Four inks as Adobe writes them (255 = none): red is magenta and yellow.
TEST(ImageFile, PrintersInksBecomeColours) {
  const TestFolder folder;
  jpeg_compress_struct info;
  jpeg_error_mgr errors;
  info.err = jpeg_std_error(&errors);
  jpeg_create_compress(&info);
  std::FILE* file = std::fopen((folder / "inks.jpg").c_str(), "wb");
  jpeg_stdio_dest(&info, file);
  info.image_width = info.image_height = 16;
  info.input_components = 4;
  info.in_color_space = JCS_CMYK;
  jpeg_set_defaults(&info);
  jpeg_simple_progression(&info);
  jpeg_start_compress(&info, TRUE);
  std::vector<JSAMPLE> row;
  for (int x = 0; x < 16; ++x) row.insert(row.end(), {255, 0, 0, 255});
  for (JSAMPROW at = row.data(); info.next_scanline < 16;) jpeg_write_scanlines(&info, &at, 1);
  jpeg_finish_compress(&info);
  jpeg_destroy_compress(&info);
  std::fclose(file);
  const ColourImage colour = read_colour(folder / "inks.jpg").value();
  EXPECT_NEAR(colour.at(8, 8, 0), 255, 2);
  EXPECT_NEAR(colour.at(8, 8, 1), 0, 2);
  EXPECT_NEAR(colour.at(8, 8, 2), 0, 2);
  EXPECT_NEAR(read_grey(folder / "inks.jpg")->at(8, 8), 76, 2);
}

TEST(ImageFile, TheNameOfTheFileDoesNotMatterItsBytesDo) {
  const TestFolder folder;
  ASSERT_TRUE(write_png(folder / "really_png.jpg", image()));
  EXPECT_TRUE(read_colour(folder / "really_png.jpg"));
  ASSERT_TRUE(write_bytes(folder / "text.jpg", "hello, this is no image"));
  EXPECT_EQ(read_colour(folder / "text.jpg").error().code, Errc::kBadFormat);
  EXPECT_EQ(read_image_header(folder / "text.jpg").error().code, Errc::kBadFormat);
  EXPECT_EQ(read_colour(folder / "missing.jpg").error().code, Errc::kNotFound);
  EXPECT_EQ(read_image_header(folder / "missing.jpg").error().code, Errc::kNotFound);
  ASSERT_TRUE(write_bytes(folder / "empty.jpg", ""));
  EXPECT_FALSE(read_colour(folder / "empty.jpg"));
  EXPECT_FALSE(read_colour(folder / "."));
}

TEST(ImageFile, ACutJpegIsAnErrorWhereverItIsCut) {
  const TestFolder folder;
  const std::string whole = encode_jpeg(image(), 90).value();
  for (std::size_t i = 0; i < 50; ++i) {
    ASSERT_TRUE(write_bytes(folder / "cut.jpg", whole.substr(0, i * (whole.size() - 1) / 49)));
    EXPECT_FALSE(read_grey(folder / "cut.jpg")) << i;
    EXPECT_FALSE(read_colour(folder / "cut.jpg", 4)) << i;
    (void)read_image_header(folder / "cut.jpg");
  }
}

TEST(ImageFile, ACutPngOrTiffIsAnErrorToo) {
  const TestFolder folder;
  ASSERT_TRUE(write_png(folder / "a.png", image()));
  write_tiff(folder / "a.tif", image(), {8, 3, COMPRESSION_LZW, PHOTOMETRIC_RGB, 2, true});
  for (const char* name : {"a.png", "a.tif"}) {
    const std::string whole = read_bytes(folder / name).value();
    for (std::size_t i = 0; i < 30; ++i) {
      ASSERT_TRUE(write_bytes(folder / "cut", whole.substr(0, i * (whole.size() - 1) / 29)));
      EXPECT_FALSE(read_colour(folder / "cut")) << name << i;
      (void)read_image_header(folder / "cut");
    }
  }
}

TEST(ImageFile, NoDamageMakesAReaderCrash) {
  const TestFolder folder;
  ImageHeader header;
  header.maker = "M";
  header.latitude_deg = 1;
  header.longitude_deg = 2;
  header.pitch_deg = -90;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 90, &header));
  ASSERT_TRUE(write_png(folder / "a.png", image()));
  write_tiff(folder / "a.tif", image(), {8, 3, COMPRESSION_LZW, PHOTOMETRIC_RGB, 2, true});
  Random random(7);
  for (const char* name : {"a.jpg", "a.png", "a.tif"}) {
    const std::string whole = read_bytes(folder / name).value();
    for (int trial = 0; trial < 150; ++trial) {
      std::string bytes = whole;
      // Headers are short; half of the trials hit only them.
      const auto range = std::uint32_t(trial % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 600));
      for (int i = 0; i < 1 + trial % 8; ++i) bytes[4 + random.below(range - 4)] = char(random.below(256));
      ASSERT_TRUE(write_bytes(folder / "flipped", bytes));
      (void)read_colour(folder / "flipped");
      (void)read_image_header(folder / "flipped");
    }
  }
}

TEST(ImageFile, AnAbsurdSizeIsRefusedBeforeMemoryIsTaken) {
  EXPECT_FALSE(check_size(60000, 30000, 1000, kTiffPxPerByte));
  EXPECT_FALSE(check_size(4'000'000'000, 4'000'000'000, 1000, kTiffPxPerByte));
  EXPECT_FALSE(check_size(0, 5, 1000, kTiffPxPerByte));
  EXPECT_TRUE(check_size(10000, 8000, 20'000'000, kTiffPxPerByte));
  EXPECT_TRUE(check_size(10000, 8000, 80'000, kJpegPxPerByte));
  EXPECT_FALSE(check_size(10000, 8000, 79'999, kJpegPxPerByte));
}

struct Tag {
  std::uint16_t tag;
  std::uint32_t value;
};

// A TIFF of nothing but these tags.
std::string tiff_of(const std::vector<Tag>& tags) {
  std::string bytes("II*\0\x08\0\0\0", 8);
  const auto put = [&](std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes += char(value >> (8 * i));
  };
  put(std::uint32_t(tags.size()), 2);
  for (const Tag& tag : tags) {
    put(tag.tag, 2);
    put(4, 2);
    put(1, 4);
    put(tag.value, 4);
  }
  put(0, 4);
  return bytes;
}

// One of 64 x 64 pixels whose only tile is stated to be this large.
std::string small_tiff_with_large_tile(std::uint32_t width, std::uint32_t height) {
  return tiff_of({{256, 64},
                  {257, 64},
                  {258, 8},
                  {259, 1},
                  {262, 1},
                  {322, width},
                  {323, height},
                  {324, 8},
                  {325, width * height}});
}

// A small file whose header states another size: refused by whoever decodes it, and by whoever reads only its header.
void expect_refused(const std::filesystem::path& path, const std::string& bytes) {
  ASSERT_TRUE(write_bytes(path, bytes));
  const auto grey = read_grey(path);
  ASSERT_FALSE(grey);
  EXPECT_NE(grey.error().message.find("40000 x 20000 pixels cannot be in"), std::string::npos) << grey.error().message;
  const auto header = read_image_header(path);
  ASSERT_FALSE(header);
  EXPECT_NE(header.error().message.find("40000 x 20000 pixels cannot be in"), std::string::npos)
      << header.error().message;
}

TEST(ImageFile, AnAbsurdSizeInASmallHeaderIsRefusedByAllReaders) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 90));
  std::string jpeg = read_bytes(folder / "a.jpg").value();
  const std::size_t frame = jpeg.find("\xff\xc0");  // then length, bits, height, width
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, "\x4e\x20\x9c\x40");
  expect_refused(folder / "b.jpg", jpeg);

  ASSERT_TRUE(write_png(folder / "a.png", image()));
  std::string png = read_bytes(folder / "a.png").value();
  png.replace(16, 8, std::string("\0\0\x9c\x40\0\0\x4e\x20", 8));
  std::uint32_t crc = ~0u;  // of "IHDR" and its content
  for (std::size_t i = 12; i < 29; ++i) {
    crc ^= std::uint8_t(png[i]);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
  }
  for (std::size_t i = 0; i < 4; ++i) png[29 + i] = char(~crc >> (24 - 8 * i));
  expect_refused(folder / "b.png", png);
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

TEST(ImageFile, AnAbsurdTileOfASmallTiffIsRefusedBeforeMemoryIsTaken) {
  const TestFolder folder;
  ASSERT_TRUE(write_bytes(folder / "a.tif", small_tiff_with_large_tile(30000, 30000)));
  const auto image = read_grey(folder / "a.tif");
  ASSERT_FALSE(image);
  EXPECT_NE(image.error().message.find("30000 x 30000 pixels cannot be in"), std::string::npos)
      << image.error().message;
}

ImageHeader full_header() {
  ImageHeader header;
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

TEST(ImageHeader, EverythingWrittenIsReadAgain) {
  const TestFolder folder;
  const ImageHeader header = full_header();
  // Wide enough that the sensor is plausible for the pixel pitch.
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(5472, 8, 1), 50, &header));
  const ImageHeader back = read_image_header(folder / "a.jpg").value();
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

TEST(ImageHeader, BelowSeaLevelAndWestSurvive) {
  const TestFolder folder;
  ImageHeader header;
  header.latitude_deg = 31.5;
  header.longitude_deg = -0.25;
  header.height_m = -420.5;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 90, &header));
  const ImageHeader back = read_image_header(folder / "a.jpg").value();
  EXPECT_NEAR(back.longitude_deg.value(), -0.25, 1e-9);
  EXPECT_NEAR(back.height_m.value(), -420.5, 1e-4);
}

TEST(ImageHeader, ZeroZeroIsNoPosition) {
  const TestFolder folder;
  ImageHeader header;
  header.latitude_deg = 0;
  header.longitude_deg = 0;
  header.height_m = 5;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 90, &header));
  const ImageHeader back = read_image_header(folder / "a.jpg").value();
  EXPECT_FALSE(back.latitude_deg || back.longitude_deg || back.height_m);
}

TEST(ImageHeader, WithoutTagsNothingIsInvented) {
  const TestFolder folder;
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 90));
  const ImageHeader back = read_image_header(folder / "a.jpg").value();
  EXPECT_EQ(back.width_px, 93);
  EXPECT_TRUE(back.maker.empty() && back.model.empty() && back.serial.empty() && back.taken.empty());
  EXPECT_FALSE(back.focal_mm || back.focal_35mm_mm || back.pixel_pitch_mm || back.latitude_deg || back.heading_deg);
  EXPECT_EQ(back.orientation, 1);
}

TEST(ImageHeader, SeveralThreadsReadAtOnce) {
  const TestFolder folder;
  const ImageHeader header = full_header();
  ASSERT_TRUE(write_jpeg(folder / "a.jpg", image(), 90, &header));
  std::array<int, 4> wrong{};
  {
    std::vector<std::jthread> threads;
    for (int& count : wrong)
      threads.emplace_back([&count, &folder] {
        for (int i = 0; i < 50; ++i) {
          const auto back = read_image_header(folder / "a.jpg");
          count += !back || back->pitch_deg != -89.9 || back->model != "FC6310R";
        }
      });
  }
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

}  // namespace
}  // namespace collinea
