// SPDX-License-Identifier: Apache-2.0
#pragma once

// What image.cc needs of the single file formats. Internal to the module.

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

struct ImageHeader;

enum class FileKind { kJpeg, kPng, kTiff };

/// By the first bytes of the file, never by its name. Errors: missing, none of the three.
[[nodiscard]] Result<FileKind> kind_of_file(const std::filesystem::path& path);
/// All bytes of a file, or the first `most`.
[[nodiscard]] Result<std::string> read_bytes(const std::filesystem::path& path,
                                             std::size_t most = std::numeric_limits<std::size_t>::max());
/// Writes beside the target and renames: the name never holds half a file.
[[nodiscard]] Result<> write_bytes(const std::filesystem::path& path, const std::string& bytes);

/// Pixels that a byte of a file can stand for at the very most, in an image of one colour. JPEG: a block of 64 pixels
/// takes a bit of its first scan. Deflate packs to 1/1032; other codecs of TIFF a little better.
inline constexpr std::uint64_t kJpegPxPerByte = 1000, kDeflateBytesPerByte = 1032, kTiffPxPerByte = 10'000;

/// Refuses sizes that this many bytes cannot hold, before memory is taken for them: what is above 16 million pixels and
/// above px_per_byte. Whoever reads an image or only its header asks this first.
[[nodiscard]] Result<> check_size(std::uint64_t width, std::uint64_t height, std::uint64_t file_bytes,
                                  std::uint64_t px_per_byte);

/// Samples as a file holds them.
struct SampleFormat {
  int width = 0, height = 0;
  int channels = 1;      ///< 1 or 3 of those of a pixel: others (transparency) are left out
  bool is_deep = false;  ///< 16 bits; else 8
};

/// A rectangle of an image as it is unpacked.
struct SamplePiece {
  int left = 0, top = 0, width = 0, height = 0;
  const void* samples = nullptr;  ///< of 16 or 8 bits, row by row
  int row_px = 0;                 ///< pixels from row to row
  int samples_of_px = 1;
};

/// An image of 8 bits and 1 or 3 channels, from the pieces of its file: no more of them than one is held. Samples of 16
/// bits are scaled from their 0.1 to their 99.9 percentiles (over all channels together: colours stay), for which they
/// are read twice. 3 -> 1 channel by the luma of BT.601 (as JPEG), 1 -> 3 by repetition.
class EightBitImage {
 public:
  explicit EightBitImage(int channels) : channels_(channels) {}

  void begin(const SampleFormat& format);
  void take(const SamplePiece& piece);
  /// To be asked when all was read: whether it has to be read once more.
  [[nodiscard]] bool wants_more();
  [[nodiscard]] Raster<std::uint8_t> image() && { return std::move(image_); }

 private:
  template <class T, class Grey>
  void convert(const SamplePiece& piece, const Grey& grey);

  int channels_;
  SampleFormat format_;
  std::vector<std::uint64_t> histogram_;  // of 16 bits, in the first reading
  std::vector<std::uint8_t> scaled_;      // by sample of 16 bits, in the second one
  Raster<std::uint8_t> image_;
};

using Size = std::array<int, 2>;  ///< width, height [px]

/// `channels` 1 (luma) or 3; `shrink` 1, 2, 4, 8 inside the decoder.
[[nodiscard]] Result<Raster<std::uint8_t>> decode_jpeg(const std::string& bytes, int channels, int shrink);
/// Size of an image whose file has so many bytes; these are the first of them.
[[nodiscard]] Result<Size> jpeg_size(const std::string& bytes, std::uint64_t file_bytes);
[[nodiscard]] Result<> decode_png(const std::string& bytes, EightBitImage& image);
[[nodiscard]] Result<Size> png_size(const std::string& bytes, std::uint64_t file_bytes);
[[nodiscard]] Result<std::string> encode_png(const Raster<std::uint8_t>& image);
[[nodiscard]] Result<> read_tiff(const std::filesystem::path& path, EightBitImage& image);
[[nodiscard]] Result<Size> tiff_size(const std::filesystem::path& path);

/// 3 -> 1 channel and 1 -> 3, as EightBitImage does.
[[nodiscard]] Raster<std::uint8_t> with_channels(Raster<std::uint8_t> image, int channels);

/// Adds EXIF and XMP to the bytes of a JPEG file.
[[nodiscard]] Result<std::string> with_header(const std::string& jpeg, const ImageHeader& header);
/// Makes Exiv2 quiet, ready for threads, and acquainted with the namespaces of drones. Cheap to call again.
void set_up_exiv2();

}  // namespace collinea
