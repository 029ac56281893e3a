// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/raster_spool.h"

#include <cstring>
#include <string>
#include <utility>

namespace collinea {

Result<RasterSpool> RasterSpool::create(const std::filesystem::path& file, int width, int height) {
  COLLINEA_TRY(RecordSpool floats, RecordSpool::create(file));
  return RasterSpool(std::move(floats), width, height);
}

void RasterSpool::append(const FloatImage& rows) {
  COLLINEA_CHECK(rows.width == width_ && rows.channels == 1);
  floats_.append({reinterpret_cast<const char*>(rows.data.data()), rows.data.size() * sizeof(float)});
}

Result<FloatImage> RasterSpool::read(int raster, int column, int row, int width, int height) const {
  COLLINEA_CHECK(raster >= 0 && column >= 0 && row >= 0 && column + width <= width_ && row + height <= height_);
  FloatImage window(width, height);
  for (int y = 0; y < height; ++y) {
    const std::uint64_t cell =
        (std::uint64_t(raster) * std::uint64_t(height_) + std::uint64_t(row + y)) * std::uint64_t(width_) +
        std::uint64_t(column);
    COLLINEA_TRY(const std::string bytes, floats_.read(cell * sizeof(float), std::uint64_t(width) * sizeof(float)));
    std::memcpy(window.row(y), bytes.data(), bytes.size());
  }
  return window;
}

}  // namespace collinea
