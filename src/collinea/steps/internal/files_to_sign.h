// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/project/project.h"
#include "collinea/report/signed_files.h"

namespace collinea {

/// The files that the report of a project vouches for, not yet hashed: photographs of the block; files that options
/// name, and those of a folder that they name; all below products/ and adjustment/. By role, then by name.
[[nodiscard]] std::vector<SignedFile> files_to_sign(const Project& project, const Block& block);

}  // namespace collinea
