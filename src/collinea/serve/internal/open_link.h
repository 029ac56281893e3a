// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"

namespace collinea {

/// Opens a link in the user's browser, by a file that only the user can read: what stands among the arguments of a
/// program, others on the machine can see. Errors: no such file can be made, no program that opens links.
[[nodiscard]] Result<> open_link(const std::string& link);

}  // namespace collinea
