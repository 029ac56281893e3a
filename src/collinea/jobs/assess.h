// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/assess/assess.h"
#include "collinea/project/project.h"

namespace collinea {

/// How far a simulated block's orientation and products are from the truth written beside its images. What was not
/// made is left out. Errors: truth missing or broken, block not oriented.
[[nodiscard]] Result<Assessment> assess_project(const Project& project, const std::filesystem::path& truth);

}  // namespace collinea
