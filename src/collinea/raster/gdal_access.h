// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gdal.h>

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>

#include "collinea/base/result.h"

namespace collinea {

/// While it lives, GDAL's errors of this thread are kept here instead of printed. Internal to the module.
class GdalErrors {
 public:
  GdalErrors();
  ~GdalErrors();
  GdalErrors(const GdalErrors&) = delete;
  GdalErrors& operator=(const GdalErrors&) = delete;

  [[nodiscard]] bool any() const { return !first_.empty(); }
  [[nodiscard]] tl::unexpected<Error> error(Errc code, const std::string& doing) const;

 private:
  static void keep(CPLErr level, int number, const char* message);
  std::string first_;  // of the errors, not the warnings
};

struct GdalCloser {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using GdalDataset = std::unique_ptr<void, GdalCloser>;

/// Registers GDAL's drivers, and bounds its cache unless GDAL_CACHEMAX does; cheap to call again.
void set_up_gdal();

/// Bounds the blocks of rasters that GDAL keeps, unless GDAL_CACHEMAX does.
void limit_block_cache(std::int64_t bytes);

template <class T>
constexpr GDALDataType gdal_type() {
  if constexpr (std::is_same_v<T, float>) return GDT_Float32;
  if constexpr (std::is_same_v<T, std::uint8_t>) return GDT_Byte;
  if constexpr (std::is_same_v<T, std::uint16_t>) return GDT_UInt16;
}

}  // namespace collinea
