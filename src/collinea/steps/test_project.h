// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>

#include "collinea/project/project.h"
#include "collinea/steps/simulated_project.h"

namespace collinea {

/// A project simulated without images, opened for `orient`; for tests.
inline Result<Project> open_simulated(const std::filesystem::path& folder, const SurveyOptions& survey,
                                      const ObservationOptions& observations, const Run& run = {}) {
  COLLINEA_TRY(simulate_project(survey, observations, folder, {}));
  COLLINEA_TRY(const Settings settings, read_settings(folder));
  return create_project(folder, settings, run);
}

/// A survey of twelve images, six control points and 120 features an image.
inline Result<Project> open_small_survey(const std::filesystem::path& folder) {
  SurveyOptions survey;
  survey.images = 12;
  survey.control_points = 6;
  return open_simulated(folder, survey, {.points_per_image = 120});
}

/// What an adjustment wrote into its folder.
inline nlohmann::json report_in(const std::filesystem::path& folder) {
  std::ifstream file(folder / "adjustment.json");
  return nlohmann::json::parse(file);
}

}  // namespace collinea
