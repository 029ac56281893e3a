// SPDX-License-Identifier: Apache-2.0
#include "collinea/image/block_cache.h"

#include <cpl_conv.h>

#include "collinea/image/gdal_access.h"

namespace collinea {

BlockCacheLimit::BlockCacheLimit(std::size_t bytes) {
  set_up_gdal();
  before_ = GDALGetCacheMax64();
  if (!CPLGetConfigOption("GDAL_CACHEMAX", nullptr)) GDALSetCacheMax64(GIntBig(bytes));
}

BlockCacheLimit::~BlockCacheLimit() {
  if (!CPLGetConfigOption("GDAL_CACHEMAX", nullptr)) GDALSetCacheMax64(before_);
}

}  // namespace collinea
