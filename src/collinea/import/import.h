// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/import/internal/imported.h"

namespace collinea {

/// Reads the headers of all images below a folder, groups cameras, and brings positions and control to a local
/// frame. Broken, duplicate and non-image files are skipped and named. Control points without any coordinate need
/// no CRS. Errors: no folder, no image at all, bad control file, bad file of measurements on the ground or one
/// that names points that are not there, bad file of positions or one of other images, CRS unknown.
[[nodiscard]] Result<Imported> import_images(const std::filesystem::path& photos, const ImportOptions& options,
                                             const Run& run);

/// What the folder of images, and the files of control, positions and measurements on the ground look like from
/// outside (names, sizes, times): changes when anything in them does.
[[nodiscard]] std::string fingerprint_of_sources(const std::filesystem::path& photos, const ImportOptions& options);

}  // namespace collinea
