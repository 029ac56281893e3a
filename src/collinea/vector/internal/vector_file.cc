// SPDX-License-Identifier: Apache-2.0
#include "collinea/vector/internal/vector_file.h"

#include <cpl_conv.h>
#include <ogr_srs_api.h>

#include <system_error>

namespace collinea {

FixedDate::FixedDate() { CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z"); }
FixedDate::~FixedDate() { CPLSetThreadLocalConfigOption("OGR_CURRENT_DATE", nullptr); }

void SrsReleaser::operator()(void* srs) const { OSRRelease(srs); }

Result<> VectorFile::create(const char* driver_name, const std::filesystem::path& path) {
  path_ = path;
  part_ = path.parent_path() / (path.stem().string() + ".part" + path.extension().string());
  remove_part();
  const GDALDriverH driver = GDALGetDriverByName(driver_name);
  if (!driver) return fail(Errc::kUnsupported, std::string("this GDAL has no driver for ") + driver_name);
  const GdalErrors errors;
  dataset_.reset(GDALCreate(driver, part_.c_str(), 0, 0, 0, GDT_Unknown, nullptr));
  if (!dataset_) return not_written(errors);
  return {};
}

Result<> VectorFile::finish() {
  {
    const GdalErrors errors;
    dataset_.reset();
    if (errors.any()) {
      remove_part();
      return not_written(errors);
    }
  }
  std::error_code failed;
  std::filesystem::rename(part_, path_, failed);
  if (failed) remove_part();
  if (failed) return fail(Errc::kBadInput, path_.string() + " cannot be written: " + failed.message());
  return {};
}

VectorFile::~VectorFile() {
  if (!dataset_) return;
  const GdalErrors muted;
  dataset_.reset();
  remove_part();
}

// With what SQLite keeps beside a GeoPackage while it writes.
void VectorFile::remove_part() const {
  std::error_code ignored;
  std::filesystem::remove(part_, ignored);
  std::filesystem::remove(part_.string() + "-journal", ignored);
}

}  // namespace collinea
