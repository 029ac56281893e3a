// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A part of an image, in whole pixels.
struct PixelWindow {
  int left = 0, top = 0, width = 0, height = 0;
};

/// A JPEG file read from the top down, some rows at a time, in its own colours: 3 channels, or 1 of a grey one. Neither
/// the file nor the image lies in memory as a whole; but of a progressive JPEG the decoder keeps all coefficients, some
/// 3 bytes a pixel (a third of them where it is reduced to 1/8 all the same).
class JpegReader {
 public:
  /// `shrink` = 1, 2, 4 or 8: every size becomes ceil(size / shrink), inside the decoder. Errors: missing, no JPEG, a
  /// size that the file cannot hold.
  static Result<JpegReader> open(const std::filesystem::path& path, int shrink = 1);

  [[nodiscard]] int width() const;          ///< of the rows
  [[nodiscard]] int height() const;         ///< rows in all
  [[nodiscard]] int channels() const;       ///< 1 or 3
  [[nodiscard]] int full_width_px() const;  ///< of the image in the file
  [[nodiscard]] int full_height_px() const;
  [[nodiscard]] bool at_end() const;  ///< all rows were read

  /// The next rows, at most `rows` of them. Errors: damaged or incomplete data.
  [[nodiscard]] Result<Raster<std::uint8_t>> read(int rows);

  JpegReader(JpegReader&&) noexcept;
  ~JpegReader();

 private:
  struct State;
  explicit JpegReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// The luma of a window of a JPEG file at its full size; of what is above it nothing but the code is read, below it
/// nothing at all. Errors: those of JpegReader; kBadFormat where the window is not inside the image.
[[nodiscard]] Result<GreyImage> read_jpeg_window(const std::filesystem::path& path, const PixelWindow& window);

}  // namespace collinea
