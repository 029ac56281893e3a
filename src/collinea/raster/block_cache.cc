// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/block_cache.h"

#include "collinea/raster/gdal_access.h"

namespace collinea {

BlockCacheLimit::BlockCacheLimit(std::size_t bytes) {
  set_up_gdal();
  before_ = GDALGetCacheMax64();
  limit_block_cache(std::int64_t(bytes));
}

BlockCacheLimit::~BlockCacheLimit() { limit_block_cache(before_); }

}  // namespace collinea
