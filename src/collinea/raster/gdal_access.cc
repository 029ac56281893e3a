// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/gdal_access.h"

#include <cpl_conv.h>
#include <cpl_error.h>

#include <mutex>

namespace collinea {
namespace {

// Memory for blocks that were read or are to be written. GDAL's own limit is a twentieth of the machine's memory: as
// long as that is not reached, whole rasters stay in memory once they were read. This is room for the windows of a
// surface and its sigmas that two tiles of an orthophoto beside each other look at; four times as much spares some per
// cent of its time.
constexpr GIntBig kBlockCache = GIntBig{64} << 20;

}  // namespace

GdalErrors::GdalErrors() { CPLPushErrorHandlerEx(&GdalErrors::keep, this); }

GdalErrors::~GdalErrors() {
  CPLPopErrorHandler();
  CPLErrorReset();
}

void GdalErrors::keep(CPLErr level, int, const char* message) {
  auto* self = static_cast<GdalErrors*>(CPLGetErrorHandlerUserData());
  if (level >= CE_Failure && self->first_.empty()) self->first_ = message && *message ? message : "unknown error";
}

tl::unexpected<Error> GdalErrors::error(Errc code, const std::string& doing) const {
  return fail(code, first_.empty() ? doing : doing + ": " + first_);
}

void set_up_gdal() {
  static std::once_flag once;
  std::call_once(once, [] {
    GDALAllRegister();
    limit_block_cache(kBlockCache);
  });
}

void limit_block_cache(std::int64_t bytes) {
  if (!CPLGetConfigOption("GDAL_CACHEMAX", nullptr)) GDALSetCacheMax64(GIntBig(bytes));
}

}  // namespace collinea
