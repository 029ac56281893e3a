// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/quality/gross_errors.h"

namespace collinea {

/// Why an adjustment is none; nothing when it is one. kIllPosed: the observations that are left, without image points
/// whose image does not see their point, are fewer than the unknowns or do not determine the block. kNotConverged: it
/// has not come to rest, or has lost image points that have no gross error, which is a result of the gross errors and
/// not of the measurements. `block`: that was adjusted.
[[nodiscard]] std::optional<Error> diverged(const Examined& adjusted, const GrossErrors& gross, const Block& block);

/// An error of an adjustment with what does not fit, by name and size, the largest first.
[[nodiscard]] Error naming(Error error, const GrossErrors& gross, const Block& block);

}  // namespace collinea
