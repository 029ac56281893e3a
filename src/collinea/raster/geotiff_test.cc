// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/geotiff.h"

#include <gdal.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "collinea/base/test_folder.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/math/random.h"
#include "collinea/raster/block_cache.h"
#include "collinea/raster/codec.h"

namespace collinea {
namespace {

MapGrid map_grid(int width, int height) {
  MapGrid grid;
  grid.west_m = 391234.5;
  grid.north_m = 5820123.25;
  grid.cell_m = 0.05;
  grid.width = width;
  grid.height = height;
  grid.wkt = LocalFrame::create("EPSG:32633", 52.5, 13.4, 0)->wkt1();
  return grid;
}

template <class T>
Raster<T> part_of(const Raster<T>& whole, int column, int row, int width, int height) {
  Raster<T> part(width, height, whole.channels);
  for (int y = 0; y < height; ++y)
    std::copy_n(&whole.at(column, row + y), std::size_t(width * whole.channels), part.row(y));
  return part;
}

template <class T>
Result<> write_in_windows(const std::filesystem::path& path, const MapGrid& grid, const Raster<T>& whole, int step,
                          const typename GeoTiffWriter<T>::Options& options) {
  auto writer = GeoTiffWriter<T>::create(path, grid, whole.channels, options);
  if (!writer) return tl::unexpected(writer.error());
  for (int row = 0; row < whole.height; row += step)
    for (int column = 0; column < whole.width; column += step) {
      const Raster<T> window =
          part_of(whole, column, row, std::min(step, whole.width - column), std::min(step, whole.height - row));
      if (const Result<> written = writer->write(column, row, window); !written) return written;
    }
  return writer->finish();
}

FloatImage terrain(int width, int height) {
  FloatImage raster(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) raster.at(x, y) = float(100 + 3 * std::sin(x * 0.02) + 2 * std::cos(y * 0.03));
  return raster;
}

ColourImage mosaic(int width, int height, int channels) {
  ColourImage raster(width, height, channels);
  Random random(5);
  for (std::uint8_t& value : raster.data) value = std::uint8_t(random.below(256));
  return raster;
}

TEST(GeoTiff, HeightsAndTheirPositionComeBackExactly) {
  const TestFolder folder;
  const FloatImage heights = terrain(700, 530);
  const MapGrid grid = map_grid(700, 530);
  ASSERT_TRUE(write_in_windows<float>(folder / "dsm.tif", grid, heights, 256,
                                      {.nodata = -9999.0, .description = "heights [m]"}));
  const GeoTiffReader reader = GeoTiffReader::open(folder / "dsm.tif").value();
  EXPECT_EQ(reader.grid().width, 700);
  EXPECT_EQ(reader.grid().height, 530);
  EXPECT_EQ(reader.grid().west_m, grid.west_m);
  EXPECT_EQ(reader.grid().north_m, grid.north_m);
  EXPECT_EQ(reader.grid().cell_m, grid.cell_m);
  EXPECT_NE(reader.grid().wkt.find("UTM zone 33N"), std::string::npos);
  EXPECT_EQ(reader.channels(), 1);
  EXPECT_EQ(reader.nodata(), -9999.0);
  EXPECT_EQ(reader.read_float(0, 0, 700, 530)->data, heights.data);
  EXPECT_EQ(reader.read_float(250, 500, 100, 30)->data, part_of(heights, 250, 500, 100, 30).data);
}

TEST(GeoTiff, WindowsThatCrossBlocksAreKeptToo) {
  const TestFolder folder;
  const FloatImage heights = terrain(700, 530);
  ASSERT_TRUE(write_in_windows<float>(folder / "dsm.tif", map_grid(700, 530), heights, 100, {}));
  EXPECT_EQ(GeoTiffReader::open(folder / "dsm.tif")->read_float(0, 0, 700, 530)->data, heights.data);
}

TEST(GeoTiff, ACloudOptimisedOrthophotoIsExactAndHasOverviews) {
  const TestFolder folder;
  ColourImage ortho = mosaic(1300, 1100, 4);
  for (std::size_t i = 3; i < ortho.data.size(); i += 4) ortho.data[i] = 255;
  ASSERT_TRUE(write_in_windows<std::uint8_t>(folder / "o.tif", map_grid(1300, 1100), ortho, 512,
                                             {.alpha = true, .cloud_optimised = true}));
  const GeoTiffReader reader = GeoTiffReader::open(folder / "o.tif").value();
  EXPECT_EQ(reader.channels(), 4);
  EXPECT_EQ(reader.read_byte(0, 0, 1300, 1100)->data, ortho.data);
  const std::string bytes = read_bytes(folder / "o.tif").value();
  EXPECT_NE(bytes.find("LAYOUT=IFDS_BEFORE_DATA"), std::string::npos);
  const Raster<std::uint8_t> small = reader.read_byte(0, 0, 1300, 1100, 325, 275).value();
  EXPECT_EQ(small.at(100, 100, 3), 255);
  EXPECT_NEAR(small.at(100, 100, 0), 127.5, 80);  // the mean of 16 random bytes: 4 sigma are 74
}

// Resampled values come from the cells: a mean of means of unequal numbers of known cells would be another one.
TEST(GeoTiff, OverviewsAreForViewersAndLeaveWhatIsReadAlone) {
  const TestFolder folder;
  const MapGrid grid{500'000, 5'300'000, 0.25, 1500, 1100, ""};
  FloatImage heights(grid.width, grid.height);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x)
      heights.at(x, y) = (x * 7 + y * 3) % 11 == 0 ? -9999 : float(x % 97) + 0.1F * float(y % 31);
  Raster<std::uint16_t> sources(grid.width, grid.height);
  for (std::size_t i = 0; i < sources.data.size(); ++i) sources.data[i] = std::uint16_t(i % 7 == 0 ? 40'000 : 3);
  for (const Overviews overviews : {Overviews::kNone, Overviews::kMean, Overviews::kNearest}) {
    const std::string name = std::to_string(int(overviews)) + ".tif";
    auto writer = GeoTiffWriter<float>::create(folder / name, grid, 1, {.nodata = -9999, .overviews = overviews});
    auto source =
        GeoTiffWriter<std::uint16_t>::create(folder / ("s" + name), grid, 1, {.nodata = 0, .overviews = overviews});
    ASSERT_TRUE(writer && source);
    ASSERT_TRUE(writer->write(0, 0, heights) && writer->finish());
    ASSERT_TRUE(source->write(0, 0, sources) && source->finish());
    EXPECT_FALSE(std::filesystem::exists(folder / (name + ".ovr")));
    const GDALDatasetH file = GDALOpen((folder / name).c_str(), GA_ReadOnly);
    ASSERT_NE(file, nullptr);
    EXPECT_EQ(GDALGetOverviewCount(GDALGetRasterBand(file, 1)), overviews == Overviews::kNone ? 0 : 2);
    GDALClose(file);
  }
  const auto plain = GeoTiffReader::open(folder / "0.tif"), with = GeoTiffReader::open(folder / "1.tif");
  ASSERT_TRUE(plain && with);
  EXPECT_EQ(with->read_float(0, 0, grid.width, grid.height)->data, heights.data);
  EXPECT_EQ(with->read_known(0, 0, 1500, 1100, 150, 110)->data.size(), 150u * 110u);
  const auto a = plain->read_float(0, 0, 1500, 1100, 150, 110), b = with->read_float(0, 0, 1500, 1100, 150, 110);
  EXPECT_EQ(a->data, b->data);
  const auto s = GeoTiffReader::open(folder / "s2.tif");
  ASSERT_TRUE(s);
  EXPECT_EQ(s->read_float(0, 0, 1500, 1100)->at(0, 0), 40'000);
}

TEST(GeoTiff, TheSameInputMakesTheSameBytes) {
  const TestFolder folder;
  const ColourImage ortho = mosaic(1500, 1200, 3);
  for (const bool cloud : {false, true}) {
    ASSERT_TRUE(write_in_windows<std::uint8_t>(folder / "a.tif", map_grid(1500, 1200), ortho, 512,
                                               {.cloud_optimised = cloud, .threads = 1}));
    ASSERT_TRUE(write_in_windows<std::uint8_t>(folder / "b.tif", map_grid(1500, 1200), ortho, 512,
                                               {.cloud_optimised = cloud, .threads = 3}));
    EXPECT_TRUE(read_bytes(folder / "a.tif").value() == read_bytes(folder / "b.tif").value()) << cloud;
  }
}

TEST(GeoTiff, WhatWasNotWrittenIsNodata) {
  const TestFolder folder;
  for (const bool cloud : {false, true}) {
    auto writer =
        GeoTiffWriter<float>::create(folder / "d.tif", map_grid(600, 600), 1,
                                     {.nodata = std::numeric_limits<double>::quiet_NaN(), .cloud_optimised = cloud});
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->write(0, 0, FloatImage(256, 256, 1, 7.0f)));
    ASSERT_TRUE(writer->finish());
    const GeoTiffReader reader = GeoTiffReader::open(folder / "d.tif").value();
    EXPECT_EQ(reader.read_float(5, 5, 1, 1)->at(0, 0), 7.0f);
    EXPECT_TRUE(std::isnan(reader.read_float(500, 500, 1, 1)->at(0, 0)));
    EXPECT_TRUE(std::isnan(reader.nodata().value()));
    // Averages leave nodata out: the mean of sevens and nothing is seven.
    EXPECT_EQ(reader.read_float(0, 0, 600, 600, 2, 2)->at(0, 0), 7.0f);
  }
}

TEST(GeoTiff, TheFileAppearsOnlyWhenFinished) {
  const TestFolder folder;
  {
    auto writer = GeoTiffWriter<float>::create(folder / "d.tif", map_grid(100, 100), 1, {});
    ASSERT_TRUE(writer);
    ASSERT_TRUE(writer->write(0, 0, FloatImage(100, 100)));
    EXPECT_FALSE(std::filesystem::exists(folder / "d.tif"));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
  ASSERT_TRUE(write_in_windows<float>(folder / "d.tif", map_grid(100, 100), FloatImage(100, 100), 256,
                                      {.cloud_optimised = true}));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 1);
}

TEST(GeoTiff, SixteenBitsAndNoPositionWork) {
  const TestFolder folder;
  MapGrid grid;
  grid.width = 300;
  grid.height = 200;
  grid.north_m = 200;
  Raster<std::uint16_t> raster(300, 200, 1, 4000);
  ASSERT_TRUE(write_in_windows<std::uint16_t>(folder / "w.tif", grid, raster, 256, {}));
  const GeoTiffReader reader = GeoTiffReader::open(folder / "w.tif").value();
  EXPECT_TRUE(reader.grid().wkt.empty());
  EXPECT_EQ(reader.grid().north_m, 200);
  EXPECT_EQ(reader.read_float(299, 199, 1, 1)->at(0, 0), 4000.0f);
}

TEST(GeoTiff, FilesThatAreNoneAreErrorsInWords) {
  const TestFolder folder;
  EXPECT_EQ(GeoTiffReader::open(folder / "missing.tif").error().code, Errc::kNotFound);
  ASSERT_TRUE(write_bytes(folder / "text.tif", "no raster"));
  EXPECT_EQ(GeoTiffReader::open(folder / "text.tif").error().code, Errc::kBadFormat);
  ASSERT_TRUE(write_bytes(folder / "grid.asc", "ncols 2\nnrows 1\nxllcorner 0\nyllcorner 0\ncellsize 1\n3 4\n"));
  const Result<GeoTiffReader> other = GeoTiffReader::open(folder / "grid.asc");
  ASSERT_FALSE(other);
  EXPECT_NE(other.error().message.find("as GeoTIFF"), std::string::npos) << other.error().message;
  EXPECT_FALSE(GeoTiffWriter<float>::create(folder / "no/such/folder/d.tif", map_grid(10, 10), 1, {}));
  EXPECT_FALSE(GeoTiffWriter<float>::create(folder / "d.tif", map_grid(0, 10), 1, {}));
}

TEST(GeoTiff, ACutFileIsAnErrorNotAHole) {
  const TestFolder folder;
  ASSERT_TRUE(write_in_windows<std::uint8_t>(folder / "a.tif", map_grid(900, 900), mosaic(900, 900, 1), 512, {}));
  const std::string whole = read_bytes(folder / "a.tif").value();
  ASSERT_TRUE(write_bytes(folder / "cut.tif", whole.substr(0, whole.size() / 2)));
  const Result<GeoTiffReader> reader = GeoTiffReader::open(folder / "cut.tif");
  if (reader) {
    EXPECT_FALSE(reader->read_byte(0, 0, 900, 900));
  }
  EXPECT_FALSE(GeoTiffReader::open(folder / "a.tif")->read_byte(899, 0, 2, 1));
}

// A raster of 4.7 MB, of which a smaller cache keeps no more than it may.
TEST(BlockCacheLimit, BoundsWhatIsKeptOfRasters) {
  const TestFolder folder;
  ASSERT_TRUE(write_in_windows<float>(folder / "dsm.tif", map_grid(1300, 900), terrain(1300, 900), 512, {}));
  const GIntBig usual = GDALGetCacheMax64();
  const auto kept_of_it = [&] {
    const GeoTiffReader reader = GeoTiffReader::open(folder / "dsm.tif").value();
    EXPECT_TRUE(reader.read_float(0, 0, 1300, 900));
    return GDALGetCacheUsed64();
  };
  EXPECT_GT(kept_of_it(), 4'000'000);
  {
    const BlockCacheLimit limit(1'000'000);
    EXPECT_LE(kept_of_it(), 1'000'000);
  }
  EXPECT_EQ(GDALGetCacheMax64(), usual);
}

TEST(FloatTiff, DepthMapsAreBitForBit) {
  const TestFolder folder;
  for (const int channels : {1, 3}) {
    FloatImage depth(211, 130, channels);
    Random random(9);
    for (float& value : depth.data) value = float(80 + random.normal());
    depth.at(3, 4) = std::numeric_limits<float>::infinity();
    depth.at(5, 6) = -0.0f;
    ASSERT_TRUE(write_float_tiff(folder / "depth.tif", depth));
    const FloatImage back = read_float_tiff(folder / "depth.tif").value();
    EXPECT_EQ(back.channels, channels);
    EXPECT_EQ(back.data, depth.data);
    EXPECT_EQ(GeoTiffReader::open(folder / "depth.tif")->read_float(0, 0, 211, 130)->data, depth.data);
  }
}

TEST(FloatTiff, BadFilesAreErrors) {
  const TestFolder folder;
  EXPECT_EQ(read_float_tiff(folder / "missing.tif").error().code, Errc::kNotFound);
  ASSERT_TRUE(write_float_tiff(folder / "d.tif", terrain(300, 300)));
  const std::string whole = read_bytes(folder / "d.tif").value();
  for (const std::size_t size : {std::size_t(0), std::size_t(7), whole.size() / 2, whole.size() - 1}) {
    ASSERT_TRUE(write_bytes(folder / "cut.tif", whole.substr(0, size)));
    EXPECT_FALSE(read_float_tiff(folder / "cut.tif")) << size;
  }
  EXPECT_FALSE(write_float_tiff(folder / "no/folder/d.tif", terrain(3, 3)));
}

}  // namespace
}  // namespace collinea
