// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "collinea/raster/gdal_access.h"

namespace collinea {

/// While it lives, GDAL writes a fixed date into GeoPackages: the same work is to give the same bytes. Internal to the
/// module.
class FixedDate {
 public:
  FixedDate();
  ~FixedDate();
  FixedDate(const FixedDate&) = delete;
  FixedDate& operator=(const FixedDate&) = delete;
};

struct SrsReleaser {
  void operator()(void* srs) const;
};
using GdalSrs = std::unique_ptr<void, SrsReleaser>;

/// A vector file that takes its name once it is whole; until then it is NAME.part.EXTENSION. Internal to the module.
class VectorFile {
 public:
  /// Errors: GDAL without the format, not writable.
  Result<> create(const char* driver_name, const std::filesystem::path& path);
  Result<> finish();

  VectorFile() = default;
  VectorFile(const VectorFile&) = delete;
  VectorFile& operator=(const VectorFile&) = delete;
  ~VectorFile();

  [[nodiscard]] void* dataset() const { return dataset_.get(); }
  /// That the file cannot be written, with what GDAL said.
  [[nodiscard]] tl::unexpected<Error> not_written(const GdalErrors& errors) const {
    return errors.error(Errc::kBadInput, path_.string() + " cannot be written");
  }

 private:
  void remove_part() const;

  std::filesystem::path path_, part_;
  GdalDataset dataset_;
};

}  // namespace collinea
