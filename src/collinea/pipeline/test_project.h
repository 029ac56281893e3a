// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/pipeline/project.h"
#include "collinea/pipeline/simulated_project.h"

namespace collinea {

/// A project simulated without photographs, opened for `orient`; for tests.
inline Result<Project> open_simulated(const std::filesystem::path& folder, const SurveyOptions& survey,
                                      const ObservationOptions& observations, const Run& run = {}) {
  if (auto made = simulate_project(survey, observations, folder, {}); !made)
    return tl::unexpected(std::move(made).error());
  COLLINEA_TRY(const Settings settings, read_settings(folder));
  return create_project(folder, settings, run);
}

}  // namespace collinea
