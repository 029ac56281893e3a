// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/project/internal/project_lock.h"
#include "collinea/project/settings.h"
#include "collinea/store/project_store.h"

namespace collinea {

/// A project opened for work.
struct Project {
  std::filesystem::path folder;
  Settings settings;
  ProjectStore store;
  Run run;
  std::shared_ptr<const ProjectLock> lock = {};  ///< held by who works on it; none: only looked at

  /// The photograph that steps work on: of film the ideal image that import made of the scan.
  [[nodiscard]] std::filesystem::path image_file(const Image& image) const {
    if (settings.import.film.calibration) return folder / "film" / ideal_image_name(image.file);
    return std::filesystem::path(settings.photos) / image.file;
  }
  /// The cloud in the map, in the form that was asked for.
  [[nodiscard]] std::filesystem::path cloud() const;
};

/// Makes the folder when missing, or opens what is there, for this program alone. `settings` are written to
/// project.json.
[[nodiscard]] Result<Project> create_project(const std::filesystem::path& folder, const Settings& settings,
                                             const Run& run);
/// Opens a project made before, to look at what it holds.
[[nodiscard]] Result<Project> open_project(const std::filesystem::path& folder, const Run& run);

/// The name of its folder, also of "." and "project/".
[[nodiscard]] std::string title_of(const Project& project);

/// The same error, with what to do where the disk is full or the database of the project is damaged: these show in many
/// positions, and in the words of many libraries.
[[nodiscard]] Error with_advice(Error error, const std::filesystem::path& folder);

}  // namespace collinea
