// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/io/project_store.h"
#include "collinea/pipeline/project_lock.h"
#include "collinea/pipeline/settings.h"

namespace collinea {

/// A project opened for work.
struct Project {
  std::filesystem::path folder;
  Settings settings;
  ProjectStore store;
  Run run;
  std::shared_ptr<const ProjectLock> lock = {};  ///< held by who works on it; none: only looked at

  [[nodiscard]] std::filesystem::path photo(const Image& image) const {
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

/// The steps in their order: import, detect, match, orient, densify, surface, terrain, ortho, report.
[[nodiscard]] std::vector<std::string> step_names();
/// An error that lists the steps, when none is called so.
[[nodiscard]] Result<> check_step_name(const std::string& name);

/// Brings everything up to and including `last` up to date: steps whose inputs and options have not changed are
/// skipped, a step broken off is continued. Log lines say what is done.
[[nodiscard]] Result<> bring_up_to(Project& project, const std::string& last);

}  // namespace collinea
