// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>

#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A JPEG file written from the top down, some rows at a time: for images that memory does not hold. The bytes are
/// those of write_jpeg().
class JpegWriter {
 public:
  /// Errors: not writable, a size that JPEG does not have.
  static Result<JpegWriter> create(const std::filesystem::path& path, int width, int height, int channels, int quality);
  /// The next rows, of the whole width.
  [[nodiscard]] Result<> write(const Raster<std::uint8_t>& rows);
  /// All rows are written: the file gets its name. Errors: disk.
  [[nodiscard]] Result<> finish();

  JpegWriter(JpegWriter&&) noexcept;
  ~JpegWriter();

 private:
  struct State;
  explicit JpegWriter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace collinea
