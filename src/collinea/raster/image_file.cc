// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/image_file.h"

#include <algorithm>
#include <cctype>
#include <new>

#include "collinea/raster/codec.h"
#include "collinea/raster/gdal_access.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

Result<Raster<std::uint8_t>> decoded(const std::filesystem::path& path, int channels, int shrink) {
  COLLINEA_TRY(const FileKind kind, kind_of_file(path));
  std::string bytes;
  if (kind != FileKind::kTiff) {
    COLLINEA_TRY(bytes, read_bytes(path));
  }
  if (kind == FileKind::kJpeg) return decode_jpeg(bytes, channels, shrink);
  EightBitImage gathered(channels);
  do {
    COLLINEA_TRY(kind == FileKind::kTiff ? read_tiff(path, gathered) : decode_png(bytes, gathered));
  } while (gathered.wants_more());
  Raster<std::uint8_t> image = std::move(gathered).image();
  return shrink == 1 ? std::move(image) : shrunk(image, shrink);
}

Result<Raster<std::uint8_t>> read_image_file(const std::filesystem::path& path, int channels, int shrink) {
  COLLINEA_CHECK(shrink == 1 || shrink == 2 || shrink == 4 || shrink == 8);
  try {
    Result<Raster<std::uint8_t>> image = decoded(path, channels, shrink);
    if (image || image.error().code == Errc::kNotFound) return image;
    return tl::unexpected(std::move(image).error().within("reading " + path.string()));
  } catch (const std::bad_alloc&) {
    return fail(Errc::kUnsupported, "reading " + path.string() + ": not enough memory for this image");
  }
}

GdalDataset opened(const std::filesystem::path& path) {
  const char* const drivers[] = {"JPEG", "PNG", "GTiff", nullptr};
  return GdalDataset(GDALOpenEx(path.c_str(), GDAL_OF_READONLY | GDAL_OF_RASTER, drivers, nullptr, nullptr));
}

}  // namespace

Result<std::optional<GreyImage>> read_known_pixels(const std::filesystem::path& path) {
  set_up_gdal();
  const GdalErrors errors;
  const GdalDataset file = opened(path);
  if (!file) return errors.error(Errc::kBadFormat, "reading " + path.string());
  GreyImage known(GDALGetRasterXSize(file.get()), GDALGetRasterYSize(file.get()));
  GreyImage one(known.width, known.height);
  for (int i = 1; i <= GDALGetRasterCount(file.get()); ++i) {
    const GDALRasterBandH band = GDALGetRasterBand(file.get(), i);
    if (GDALGetRasterColorInterpretation(band) == GCI_AlphaBand) continue;
    const int flags = GDALGetMaskFlags(band);
    if (flags & GMF_ALL_VALID) return std::optional<GreyImage>();
    if (GDALRasterIO(GDALGetMaskBand(band), GF_Read, 0, 0, one.width, one.height, one.data.data(), one.width,
                     one.height, GDT_Byte, 0, 0) != CE_None)
      return errors.error(Errc::kBadFormat, "reading the mask of " + path.string());
    for (std::size_t k = 0; k < one.data.size(); ++k)
      if (one.data[k] != 0) known.data[k] = 255;
    if (flags & GMF_PER_DATASET) break;
  }
  if (std::ranges::find(known.data, std::uint8_t{0}) == known.data.end()) return std::optional<GreyImage>();
  return std::optional(std::move(known));
}

bool is_image_name(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".jpg" || extension == ".jpeg" || extension == ".png" || extension == ".tif" ||
         extension == ".tiff";
}

Result<ColourImage> read_colour(const std::filesystem::path& path, int shrink) {
  return read_image_file(path, 3, shrink);
}

Result<GreyImage> read_grey(const std::filesystem::path& path, int shrink) { return read_image_file(path, 1, shrink); }

Result<int> channels_of(const std::filesystem::path& path) {
  set_up_gdal();
  const GdalErrors errors;
  const GdalDataset file = opened(path);
  if (!file) return errors.error(Errc::kBadFormat, "reading " + path.string());
  const bool is_grey =
      GDALGetRasterCount(file.get()) == 1 && !GDALGetRasterColorTable(GDALGetRasterBand(file.get(), 1));
  return is_grey ? 1 : 3;
}

Result<> write_jpeg(const std::filesystem::path& path, const Raster<std::uint8_t>& image, int quality,
                    const ImageHeader* header) {
  COLLINEA_TRY(std::string bytes, encode_jpeg(image, quality));
  if (header) {
    ImageHeader sized = *header;
    sized.width_px = image.width;
    sized.height_px = image.height;
    COLLINEA_TRY(bytes, with_header(bytes, sized));
  }
  return write_bytes(path, bytes);
}

Result<> write_png(const std::filesystem::path& path, const Raster<std::uint8_t>& image) {
  COLLINEA_TRY(const std::string bytes, encode_png(image));
  return write_bytes(path, bytes);
}

}  // namespace collinea
