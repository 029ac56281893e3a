// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "collinea/project/project.h"
#include "collinea/steps/step.h"

namespace collinea {

/// The steps in their order: import, detect, match, orient, densify, surface, terrain, ortho, report.
[[nodiscard]] std::vector<std::string> step_names();
/// An error that lists the steps, when none is called so.
[[nodiscard]] Result<> check_step_name(const std::string& name);

/// Brings everything up to and including `last` up to date: steps whose inputs and options have not changed are
/// skipped, a step broken off is continued. Log lines say what is done.
[[nodiscard]] Result<> bring_up_to(Project& project, const std::string& last);

/// Records a step as done with what the store holds already, so that the later ones go on from it. The steps before it
/// must be recorded.
Result<> record_done(Project& project, const StepOutput& output);

}  // namespace collinea
