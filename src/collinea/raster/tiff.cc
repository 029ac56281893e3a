// SPDX-License-Identifier: Apache-2.0
#include <tiffio.h>

#include <algorithm>
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

// Copies the wanted channels of a block of pixels whose upper-left corner is (left, top).
template <class T>
void paste(Raster<T>& raster, int left, int top, const T* block, int block_width, int block_height, int samples) {
  const int columns = std::min(block_width, raster.width - left), rows = std::min(block_height, raster.height - top);
  for (int y = 0; y < rows; ++y) {
    const T* from = block + std::size_t(y) * std::size_t(block_width) * std::size_t(samples);
    T* to = raster.row(top + y) + std::size_t(left) * std::size_t(raster.channels);
    for (int x = 0; x < columns; ++x)
      for (int c = 0; c < raster.channels; ++c) to[x * raster.channels + c] = from[x * samples + c];
  }
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

template <class T>
bool read_blocks(TIFF* tiff, const Layout& it, Raster<T>& raster) {
  const int width = it.tiled ? int(it.tile_width) : raster.width;
  const int height = it.tiled ? int(it.tile_height) : int(std::min<std::uint32_t>(it.rows_per_strip, it.height));
  if (width < 1 || height < 1) return false;
  const tmsize_t size = it.tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
  const std::size_t expected = std::size_t(width) * std::size_t(height) * it.samples * sizeof(T);
  if (size <= 0 || std::size_t(size) != expected || expected > (std::size_t(1) << 32)) return false;
  std::vector<T> block(expected / sizeof(T));
  for (int top = 0; top < raster.height; top += height)
    for (int left = 0; left < raster.width; left += width) {
      const tmsize_t got = it.tiled ? TIFFReadTile(tiff, block.data(), std::uint32_t(left), std::uint32_t(top), 0, 0)
                                    : TIFFReadEncodedStrip(tiff, std::uint32_t(top / height), block.data(), size);
      const int rows = it.tiled ? height : std::min(height, raster.height - top);
      if (got < tmsize_t(std::size_t(width) * std::size_t(rows) * it.samples * sizeof(T))) return false;
      paste(raster, left, top, block.data(), width, rows, it.samples);
    }
  return true;
}

// Palettes, JPEG inside TIFF, inverted grey, separate planes ...: libtiff's own conversion to RGBA.
Result<Samples> read_converted(TiffFile& file, const Layout& it) {
  char reason[1024] = {};
  if (!TIFFRGBAImageOK(file.get(), reason))
    return fail(Errc::kUnsupported, std::string("this kind of TIFF: ") + reason);
  std::vector<std::uint32_t> pixels(std::size_t(it.width) * it.height);
  if (!TIFFReadRGBAImageOriented(file.get(), it.width, it.height, pixels.data(), it.orientation, 1))
    return file.error();
  Samples samples;
  samples.bytes = Raster<std::uint8_t>(int(it.width), int(it.height), 3);
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    samples.bytes.data[3 * i] = std::uint8_t(TIFFGetR(pixels[i]));
    samples.bytes.data[3 * i + 1] = std::uint8_t(TIFFGetG(pixels[i]));
    samples.bytes.data[3 * i + 2] = std::uint8_t(TIFFGetB(pixels[i]));
  }
  return samples;
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

Result<Samples> read_tiff(const std::filesystem::path& path) {
  TiffFile file(path, "r");
  if (!file.get()) return file.error();
  const Layout it = layout_of(file.get());
  COLLINEA_TRY(check_layout(it, bytes_of(path)));
  if (!it.plain()) return read_converted(file, it);
  Samples samples;
  const int width = int(it.width), height = int(it.height);
  const int channels = it.photometric == PHOTOMETRIC_RGB ? 3 : 1;
  bool read = false;
  if (it.bits == 16) {
    samples.words = Raster<std::uint16_t>(width, height, channels);
    read = read_blocks(file.get(), it, samples.words);
  } else {
    samples.bytes = Raster<std::uint8_t>(width, height, channels);
    read = read_blocks(file.get(), it, samples.bytes);
  }
  if (!read) return file.error();
  return samples;
}

Result<Size> tiff_size(const std::filesystem::path& path) {
  TiffFile file(path, "r");
  if (!file.get()) return file.error();
  const Layout it = layout_of(file.get());
  COLLINEA_TRY(check_layout(it, bytes_of(path)));
  return Size{int(it.width), int(it.height)};
}

}  // namespace collinea
