// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>

namespace collinea {

/// While it lives, at most so many bytes of rasters that were read or are to be written stay in memory, unpacked, in
/// GDAL's cache; before and after it is as much as set_up_gdal says. For work that looks at everything once, in order:
/// that needs no more than the squares where one window ends and the next begins. One at a time in a process, or one
/// within another. The environment variable GDAL_CACHEMAX goes before it.
class BlockCacheLimit {
 public:
  explicit BlockCacheLimit(std::size_t bytes);
  ~BlockCacheLimit();
  BlockCacheLimit(const BlockCacheLimit&) = delete;
  BlockCacheLimit& operator=(const BlockCacheLimit&) = delete;

 private:
  std::int64_t before_ = 0;
};

/// What rasters as wide as a few thousand cells take that are read in pieces from top to bottom, and one piece that is
/// written: less, and squares are unpacked twice; more saves no time.
inline constexpr std::size_t kCacheOfPieces = std::size_t{32} << 20;

}  // namespace collinea
