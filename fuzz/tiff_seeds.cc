// SPDX-License-Identifier: Apache-2.0
#include "tiff_seeds.h"

#include <tiffio.h>

#include <cstdint>

#include "target.h"

namespace collinea::fuzz {
namespace {

struct Kind {
  int bits = 8, samples = 1, photometric = PHOTOMETRIC_MINISBLACK, compression = COMPRESSION_NONE;
  bool tiled = false;
};

std::string tiff_of(const Kind& kind) {
  constexpr std::uint32_t kWidth = 24, kHeight = 16;
  const std::filesystem::path path = folder() / "seed.tif";
  TIFF* tiff = TIFFOpen(path.c_str(), "w");
  if (!tiff) return "";
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kWidth);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kHeight);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, kind.bits);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, kind.samples);
  TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, kind.photometric);
  TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, kind.compression);
  if (kind.photometric == PHOTOMETRIC_PALETTE) {
    std::vector<std::uint16_t> ramp(256);
    for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = std::uint16_t(257 * i);
    TIFFSetField(tiff, TIFFTAG_COLORMAP, ramp.data(), ramp.data(), ramp.data());
  }
  if (kind.tiled) {
    TIFFSetField(tiff, TIFFTAG_TILEWIDTH, 16u);
    TIFFSetField(tiff, TIFFTAG_TILELENGTH, 16u);
  } else {
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 8u);
  }
  const auto size = kind.tiled ? TIFFTileSize(tiff) : TIFFStripSize(tiff);
  const std::uint32_t blocks = kind.tiled ? TIFFNumberOfTiles(tiff) : TIFFNumberOfStrips(tiff);
  for (std::uint32_t i = 0; i < blocks; ++i) {
    std::vector<std::uint8_t> block(static_cast<std::size_t>(size));
    for (std::size_t k = 0; k < block.size(); ++k) block[k] = std::uint8_t(k * 5 + i);
    if (kind.tiled)
      TIFFWriteEncodedTile(tiff, i, block.data(), size);
    else
      TIFFWriteEncodedStrip(tiff, i, block.data(), size);
  }
  TIFFClose(tiff);
  return bytes_of(path);
}

}  // namespace

std::vector<std::string> tiff_seeds() {
  return {tiff_of({}),
          tiff_of({.samples = 3, .photometric = PHOTOMETRIC_RGB, .compression = COMPRESSION_LZW}),
          tiff_of({.bits = 16, .compression = COMPRESSION_ADOBE_DEFLATE}),
          tiff_of({.samples = 3, .photometric = PHOTOMETRIC_RGB, .tiled = true}),
          tiff_of({.photometric = PHOTOMETRIC_PALETTE, .compression = COMPRESSION_PACKBITS}),
          tiff_of({.bits = 1, .photometric = PHOTOMETRIC_MINISWHITE})};
}

}  // namespace collinea::fuzz
