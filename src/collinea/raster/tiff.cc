// SPDX-License-Identifier: Apache-2.0
#include <tiffio.h>

#include <algorithm>
#include <bit>
#include <cstdarg>
#include <cstdio>
#include <memory>
#include <vector>

#include "collinea/raster/codec.h"
#include "collinea/raster/internal/tiff_file.h"

namespace collinea {
namespace {

struct Layout {
  std::uint32_t width = 0, height = 0, rows_per_strip = 0, tile_width = 0, tile_height = 0;
  std::uint16_t bits = 1, samples = 1, photometric = 0, planar = 1, format = 1, compression = 1, orientation = 1;
  bool tiled = false;

  bool plain() const {
    const bool grey = photometric == PHOTOMETRIC_MINISBLACK;
    const bool colour = photometric == PHOTOMETRIC_RGB && samples >= 3;
    return (bits == 8 || bits == 16) && format == SAMPLEFORMAT_UINT && (grey || colour) &&
           (planar == PLANARCONFIG_CONTIG || samples == 1);
  }
};

Layout layout_of(TIFF* tiff) {
  Layout it;
  TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &it.width);
  TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &it.height);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &it.bits);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &it.samples);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_PLANARCONFIG, &it.planar);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &it.format);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &it.compression);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ORIENTATION, &it.orientation);
  TIFFGetFieldDefaulted(tiff, TIFFTAG_ROWSPERSTRIP, &it.rows_per_strip);
  TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &it.photometric);
  TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &it.tile_width);
  TIFFGetField(tiff, TIFFTAG_TILELENGTH, &it.tile_height);
  it.tiled = TIFFIsTiled(tiff);
  return it;
}

// Pixels that a byte of the file can stand for: of a file that is not compressed at most those that lie in it.
std::uint64_t px_per_byte(const Layout& it) {
  const std::uint32_t bits_per_px = std::clamp(std::uint32_t(it.bits) * it.samples, 1u, 8u);
  return it.compression == COMPRESSION_NONE ? 8 / bits_per_px : kTiffPxPerByte;
}

// A strip or tile is unpacked as a whole, with all its samples: a tile may be stated to be of any size, a pixel to have
// 65535 samples.
Result<> check_layout(const Layout& it, std::uint64_t file_bytes) {
  COLLINEA_TRY(check_size(it.width, it.height, file_bytes, px_per_byte(it)));
  const std::uint64_t width = it.tiled ? it.tile_width : it.width;
  const std::uint64_t height = it.tiled ? it.tile_height : std::min(it.rows_per_strip, it.height);
  return check_size(width, height * it.samples, file_bytes, kTiffPxPerByte).map_error([&](Error error) {
    return std::move(error).within(it.tiled ? "a tile" : "a strip");
  });
}

bool read_blocks(TIFF* tiff, const Layout& it, const SampleFormat& format, EightBitImage& image) {
  const int width = it.tiled ? int(it.tile_width) : format.width;
  const int height = it.tiled ? int(it.tile_height) : int(std::min<std::uint32_t>(it.rows_per_strip, it.height));
  if (width < 1 || height < 1) return false;
  const tmsize_t size = it.tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
  const std::size_t bytes_of_row = std::size_t(width) * it.samples * (format.is_deep ? 2 : 1);
  const std::size_t expected = bytes_of_row * std::size_t(height);
  if (size <= 0 || std::size_t(size) != expected || expected > (std::size_t(1) << 32)) return false;
  std::vector<std::uint8_t> block(expected);
  image.begin(format);
  for (int top = 0; top < format.height; top += height)
    for (int left = 0; left < format.width; left += width) {
      const tmsize_t got = it.tiled ? TIFFReadTile(tiff, block.data(), std::uint32_t(left), std::uint32_t(top), 0, 0)
                                    : TIFFReadEncodedStrip(tiff, std::uint32_t(top / height), block.data(), size);
      const int rows = std::min(height, format.height - top);
      if (got < tmsize_t(bytes_of_row * std::size_t(it.tiled ? height : rows))) return false;
      image.take({.left = left,
                  .top = top,
                  .width = std::min(width, format.width - left),
                  .height = rows,
                  .samples = block.data(),
                  .row_px = width,
                  .samples_of_px = it.samples});
    }
  return true;
}

// Palettes, JPEG inside TIFF, inverted grey, separate planes ...: libtiff's own conversion to RGBA.
Result<> read_converted(TiffFile& file, const Layout& it, EightBitImage& image) {
  static_assert(std::endian::native == std::endian::little, "red is the first byte of libtiff's pixels");
  char reason[1024] = {};
  if (!TIFFRGBAImageOK(file.get(), reason))
    return fail(Errc::kUnsupported, std::string("this kind of TIFF: ") + reason);
  std::vector<std::uint32_t> pixels(std::size_t(it.width) * it.height);
  if (!TIFFReadRGBAImageOriented(file.get(), it.width, it.height, pixels.data(), it.orientation, 1))
    return file.error();
  const int width = int(it.width), height = int(it.height);
  image.begin({.width = width, .height = height, .channels = 3});
  image.take({.width = width, .height = height, .samples = pixels.data(), .row_px = width, .samples_of_px = 4});
  return {};
}

std::uint64_t bytes_of(const std::filesystem::path& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0 : size;
}

int remember(TIFF*, void* user, const char*, const char* format, va_list arguments) {
  auto* message = static_cast<std::string*>(user);
  char text[500];
  std::vsnprintf(text, sizeof text, format, arguments);
  if (message->empty()) *message = text;
  return 1;  // told: the global handler, which prints, is not asked
}

int ignore(TIFF*, void*, const char*, const char*, va_list) { return 1; }

}  // namespace

TiffFile::TiffFile(const std::filesystem::path& path, const char* mode) : message_(std::make_unique<std::string>()) {
  TIFFOpenOptions* options = TIFFOpenOptionsAlloc();
  TIFFOpenOptionsSetErrorHandlerExtR(options, remember, message_.get());
  TIFFOpenOptionsSetWarningHandlerExtR(options, ignore, nullptr);
  tiff_ = TIFFOpenExt(path.c_str(), mode, options);
  TIFFOpenOptionsFree(options);
}

TiffFile::~TiffFile() { close(); }

void TiffFile::close() {
  if (tiff_) TIFFClose(tiff_);
  tiff_ = nullptr;
}

tl::unexpected<Error> TiffFile::error() const {
  return fail(Errc::kBadFormat, "damaged or incomplete TIFF" + (message_->empty() ? "" : ": " + *message_));
}

Result<> read_tiff(const std::filesystem::path& path, EightBitImage& image) {
  TiffFile file(path, "r");
  if (!file.get()) return file.error();
  const Layout it = layout_of(file.get());
  COLLINEA_TRY(check_layout(it, bytes_of(path)));
  if (!it.plain()) return read_converted(file, it, image);
  const SampleFormat format{.width = int(it.width),
                            .height = int(it.height),
                            .channels = it.photometric == PHOTOMETRIC_RGB ? 3 : 1,
                            .is_deep = it.bits == 16};
  if (!read_blocks(file.get(), it, format, image)) return file.error();
  return {};
}

Result<Size> tiff_size(const std::filesystem::path& path) {
  TiffFile file(path, "r");
  if (!file.get()) return file.error();
  const Layout it = layout_of(file.get());
  COLLINEA_TRY(check_layout(it, bytes_of(path)));
  return Size{int(it.width), int(it.height)};
}

}  // namespace collinea
