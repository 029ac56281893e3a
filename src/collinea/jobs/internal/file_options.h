// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/io/adjustment_file.h"
#include "collinea/orient/adjustment.h"

namespace collinea {

// How an adjustment is done, as an adjustment file states it: each option of AdjustmentOptions by its name, with its
// value as it is typed.

/// The options that the lines of a file state, the others as they are by default. Errors: kBadFormat (an option that
/// there is not, a value that it cannot have), with the line.
[[nodiscard]] Result<AdjustmentOptions> options_in(const std::vector<AdjustmentFileOption>& stated);

/// Those that are not as they are by default.
[[nodiscard]] std::vector<AdjustmentFileOption> changed_options(const AdjustmentOptions& options);

/// All by which a task that was written as an adjustment file is adjusted once more in the same way: what the file does
/// not hold already in its parameters, roles, standard deviations and instruments, defaults that differ for files too.
[[nodiscard]] std::vector<AdjustmentFileOption> options_of(const AdjustmentTask& task, AdjustmentOptions asked);

}  // namespace collinea
