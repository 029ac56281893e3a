// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace collinea {

/// The folder of the project's sources on the machine that built a test: where the manual and shared data are found.
/// For tests only.
const char* source_tree();

}  // namespace collinea
