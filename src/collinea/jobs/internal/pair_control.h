// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/jobs/internal/pair_steps.h"

namespace collinea {

/// Orients the model on the ground by control of a table, which is intersected in it: fills `absolute` and
/// `control_names` of the report. Errors: the table, points beyond the film or whose rays do not meet, as
/// absolute_orientation().
[[nodiscard]] Result<> orient_absolutely(const std::filesystem::path& file, const PairFiles& pair,
                                         const PairModel& model, double sigma_px, PairReport& report);

}  // namespace collinea
