// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "collinea/raster/codec.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/image_file.h"
#include "target.h"
#include "tiff_seeds.h"

namespace collinea::fuzz {
namespace {

Raster<std::uint8_t> stripes(int channels) {
  Raster<std::uint8_t> image(24, 16, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) image.data[i] = std::uint8_t(i * 7);
  return image;
}

ImageHeader drone_header() {
  ImageHeader header;
  header.maker = "DJI";
  header.model = "FC6310";
  header.focal_mm = 8.8;
  header.focal_35mm_mm = 24;
  header.taken = "2024:05:17 10:31:08.25";
  header.latitude_deg = 48.1;
  header.longitude_deg = 15.3;
  header.height_m = 412;
  header.relative_height_m = 100;
  header.sigma_east_m = header.sigma_north_m = header.sigma_height_m = 0.02;
  header.heading_deg = 10;
  header.pitch_deg = -90;
  header.roll_deg = 0;
  return header;
}

std::string jpeg_with_header() {
  const std::filesystem::path path = folder() / "seed.jpg";
  const ImageHeader header = drone_header();
  (void)write_jpeg(path, stripes(3), 80, &header);
  return bytes_of(path);
}

std::string png(int channels) { return encode_png(stripes(channels)).value_or(""); }

FloatImage ramp() {
  FloatImage depth(24, 16);
  for (std::size_t i = 0; i < depth.data.size(); ++i) depth.data[i] = float(i);
  return depth;
}

std::string float_tiff() {
  (void)write_float_tiff(folder() / "seed.tif", ramp());
  return bytes_of(folder() / "seed.tif");
}

std::string geotiff() {
  const MapGrid grid{.west_m = 500000, .north_m = 5300000, .cell_m = 0.5, .width = 24, .height = 16, .wkt = ""};
  {
    auto writer = GeoTiffWriter<float>::create(folder() / "seed.tif", grid, 1, {.nodata = -9999});
    if (!writer || !writer->write(0, 0, ramp()) || !writer->finish()) return "";
  }
  return bytes_of(folder() / "seed.tif");
}

bool decodes(const std::filesystem::path& path) {
  const bool colour = read_colour(path).has_value();
  return read_grey(path, 2).has_value() && colour;
}

// These two need no file; what looks at the first bytes and leads here is in the other targets.
bool accepts_jpeg(std::string_view bytes) {
  const std::string file(bytes);
  const bool colour = decode_jpeg(file, 3, 1).has_value();
  return decode_jpeg(file, 1, 2).has_value() && jpeg_size(file, file.size()) && colour;
}

bool accepts_png(std::string_view bytes) {
  const std::string file(bytes);
  EightBitImage image(1);
  do {
    if (!decode_png(file, image)) return false;
  } while (image.wants_more());
  return png_size(file, file.size()) && std::move(image).image().channels == 1;
}

bool accepts_geotiff(std::string_view bytes) {
  const auto reader = GeoTiffReader::open(file_of(bytes, "map.tif"));
  if (!reader) return false;
  const MapGrid& grid = reader->grid();
  const int width = std::min(grid.width, 64), height = std::min(grid.height, 64);
  COLLINEA_CHECK(std::isfinite(grid.west_m) && std::isfinite(grid.north_m) && grid.cell_m > 0);
  if (reader->channels() > 16) return false;
  return reader->read_known(grid.width - width, grid.height - height, width, height).has_value() &&
         reader->read_byte(0, 0, width, height, (width + 1) / 2, (height + 1) / 2).has_value();
}

}  // namespace

std::vector<Target> image_targets() {
  const std::string grey = encode_jpeg(stripes(1), 80).value_or(""), colour = encode_jpeg(stripes(3), 90).value_or("");
  return {
      {"jpeg", accepts_jpeg, {grey, colour}},
      {"png", accepts_png, {png(1), png(3), png(4)}},
      {"tiff", [](std::string_view bytes) { return decodes(file_of(bytes, "a.tif")); }, tiff_seeds()},
      {"image_header",
       [](std::string_view bytes) { return read_image_header(file_of(bytes, "header.jpg")).has_value(); },
       {jpeg_with_header(), png(3), tiff_seeds().front()}},
      {"float_tiff",
       [](std::string_view bytes) { return read_float_tiff(file_of(bytes, "depth.tif")).has_value(); },
       {float_tiff()}},
      {"geotiff", accepts_geotiff, {geotiff()}},
  };
}

}  // namespace collinea::fuzz
