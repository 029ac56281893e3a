// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/run.h"
#include "collinea/synthetic/survey.h"

namespace collinea {

/// Writes a project as if the images of the survey had been imported, detected and matched, without making any:
/// `orient` goes on from it. Cameras and positions are as headers would give them, pairs are verified as matching
/// verifies them. The truth lies in FOLDER/truth. Errors: options, folder not writable, stopped.
[[nodiscard]] Result<> simulate_project(const SurveyOptions& survey, const ObservationOptions& observations,
                                        const std::filesystem::path& folder, const Run& run);

}  // namespace collinea
