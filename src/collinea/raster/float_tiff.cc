// SPDX-License-Identifier: Apache-2.0
#include <tiffio.h>

#include <new>

#include "collinea/raster/codec.h"
#include "collinea/raster/geotiff.h"
#include "collinea/raster/internal/tiff_file.h"

namespace collinea {
namespace {

constexpr int kRowsPerStrip = 64;

// ZSTD at its fastest behind the integer predictor: read at twice the speed of the floating-point predictor, which
// would save another quarter of the space.
void describe(TIFF* tiff, const FloatImage& raster) {
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, std::uint32_t(raster.width));
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, std::uint32_t(raster.height));
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, raster.channels);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, kRowsPerStrip);
  const bool zstd = TIFFIsCODECConfigured(COMPRESSION_ZSTD);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, zstd ? COMPRESSION_ZSTD : COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, PREDICTOR_HORIZONTAL);
  TIFFSetField(tiff, zstd ? TIFFTAG_ZSTD_LEVEL : TIFFTAG_ZIPQUALITY, 1);
  if (raster.channels > 1) {
    const std::vector<std::uint16_t> meaning(std::size_t(raster.channels - 1), EXTRASAMPLE_UNSPECIFIED);
    TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, raster.channels - 1, meaning.data());
  }
}

bool write_strips(TIFF* tiff, const FloatImage& raster) {
  const std::size_t row = std::size_t(raster.width) * std::size_t(raster.channels);
  std::vector<float> strip(row * kRowsPerStrip);  // the predictor works in place, so it gets a copy
  for (int top = 0; top < raster.height; top += kRowsPerStrip) {
    const std::size_t count = row * std::size_t(std::min(kRowsPerStrip, raster.height - top));
    std::copy_n(raster.row(top), count, strip.data());
    const auto size = tmsize_t(count * sizeof(float));
    if (TIFFWriteEncodedStrip(tiff, std::uint32_t(top / kRowsPerStrip), strip.data(), size) != size) return false;
  }
  return TIFFFlush(tiff) == 1;
}

struct FloatLayout {
  std::uint32_t width = 0, height = 0, rows = 0;
  std::uint16_t bits = 1, format = 1, samples = 1, planar = 1;
};

FloatLayout layout_of(TIFF* tiff) {
  FloatLayout it;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &it.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &it.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &it.rows);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &it.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &it.format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &it.samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &it.planar);
  return it;
}

bool read_strips(TIFF* tiff, int rows, FloatImage& raster) {
  const std::size_t row = std::size_t(raster.width) * std::size_t(raster.channels);
  for (int top = 0; top < raster.height; top += rows) {
    const auto size = tmsize_t(row * std::size_t(std::min(rows, raster.height - top)) * sizeof(float));
    if (TIFFReadEncodedStrip(tiff, std::uint32_t(top / rows), raster.row(top), size) != size) return false;
  }
  return true;
}

Result<FloatImage> read_all(const std::filesystem::path& path) {
  TiffFile file(path, "r");
  if (!file.get()) return file.error();
  const FloatLayout it = layout_of(file.get());
  if (it.bits != 32 || it.format != SAMPLEFORMAT_IEEEFP || TIFFIsTiled(file.get()) || it.rows == 0 ||
      (it.planar != PLANARCONFIG_CONTIG && it.samples > 1))
    return fail(Errc::kUnsupported, "not a floating-point raster in strips");
  std::error_code ignored;
  COLLINEA_TRY(check_size(it.width, std::uint64_t(it.height) * it.samples, std::filesystem::file_size(path, ignored),
                          kTiffPxPerByte));
  FloatImage raster(int(it.width), int(it.height), it.samples);
  if (!read_strips(file.get(), int(std::min(it.rows, it.height)), raster)) return file.error();
  return raster;
}

}  // namespace

Result<> write_float_tiff(const std::filesystem::path& path, const FloatImage& raster) {
  COLLINEA_CHECK(!raster.empty());
  std::filesystem::path part = path;
  part += ".part";
  bool written = false;
  std::string message;
  {
    // "8": BigTIFF where four-byte offsets might not do.
    TiffFile file(part, raster.data.size() > 900'000'000 ? "w8" : "w");
    if (file.get()) {
      describe(file.get(), raster);
      written = write_strips(file.get(), raster);
      file.close();
    }
    written = written && file.message().empty();
    message = file.message();
  }
  std::error_code error, ignored;
  if (written) std::filesystem::rename(part, path, error);
  if (written && !error) return {};
  std::filesystem::remove(part, ignored);
  return fail(Errc::kBadInput, path.string() + " cannot be written: " + (error ? error.message() : message));
}

Result<FloatImage> read_float_tiff(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return fail(Errc::kNotFound, path.string() + ": no such file");
  try {
    Result<FloatImage> raster = read_all(path);
    if (!raster) return tl::unexpected(std::move(raster).error().within("reading " + path.string()));
    return raster;
  } catch (const std::bad_alloc&) {
    return fail(Errc::kUnsupported, "reading " + path.string() + ": not enough memory");
  }
}

}  // namespace collinea
