// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/project/project.h"
#include "collinea/steps/step_list.h"

namespace collinea {

/// What a step leaves: products lie in the project folder, blocks and features in its store.
struct StepOutput {
  std::string output_hash;  ///< of what later steps read from it
  StepOutcome outcome;
};

/// The steps. `inputs_hash` is the fingerprint of all that the step reads; work done under another one is not reused.
Result<StepOutput> import_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> detect_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> match_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> orient_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> adjust_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> densify_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> surface_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> terrain_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> ortho_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> frames_step(Project& project, const std::string& inputs_hash);
Result<StepOutput> report_step(Project& project, const std::string& inputs_hash);

}  // namespace collinea
