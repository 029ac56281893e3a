// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/record_spool.h"
#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Rasters of one size and one channel that lie on disk, unpacked, while they are worked on (RecordSpool).
class RasterSpool {
 public:
  /// Beside `file`, where there must be room. Errors: not writable.
  static Result<RasterSpool> create(const std::filesystem::path& file, int width, int height);
  /// The next rows, of the whole width; one raster after the other.
  void append(const FloatImage& rows);
  /// A window inside a raster, of which 0 is the first; from several threads at once, but not while rows are appended.
  /// Errors: something could not be written (full disk), or is not there.
  [[nodiscard]] Result<FloatImage> read(int raster, int column, int row, int width, int height) const;

 private:
  RasterSpool(RecordSpool floats, int width, int height) : floats_(std::move(floats)), width_(width), height_(height) {}

  RecordSpool floats_;
  int width_, height_;
};

}  // namespace collinea
