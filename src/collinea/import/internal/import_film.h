// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "collinea/import/internal/imported.h"
#include "collinea/raster/image_file.h"

namespace collinea {

/// A folder of scans of film from one camera.
struct FilmFolder {
  IdealImage ideal;
  std::map<std::string, Result<ScanOrientation>> scans;  ///< by file; or why there is none
  /// How the scans are deformed between their marks, by file, where there is any: each then has a camera of its own.
  std::map<std::string, FilmPrior> deformed = {};

  /// As that of a photograph with the size of the ideal image.
  [[nodiscard]] ImageHeader header() const;
};

/// Finds the marks of every scan and orients it; the ideal image has pixels of the scans' size (the median). Errors:
/// the calibration, options that contradict it, no scan with marks.
[[nodiscard]] Result<FilmFolder> film_folder(const std::filesystem::path& photos, const std::vector<std::string>& files,
                                             const ImportOptions& options, const Run& run);

/// Scans whose marks do not lie as the others' do become findings.
void name_poor_scans(Imported& imported);

}  // namespace collinea
