// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

#include "collinea/project/project.h"
#include "collinea/steps/step.h"

namespace collinea {

/// The step of this name. An error that lists the steps, when none is called so.
[[nodiscard]] Result<Step> step_named(std::string_view name);

/// Brings everything up to and including `last` up to date: steps whose inputs and options have not changed are
/// skipped, a step broken off is continued. Log lines say what is done.
[[nodiscard]] Result<> bring_up_to(Project& project, Step last);

/// Records a step as done with what the store holds already, so that the later ones go on from it. The steps before it
/// must be recorded.
Result<> record_done(Project& project, const StepOutput& output);

}  // namespace collinea
