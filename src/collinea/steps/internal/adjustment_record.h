// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/orient/adjustment.h"
#include "collinea/store/project_store.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// What the project keeps of its adjustment beside the block. `orientation`: how the block was found. `setup`: with all
/// measurements; control that was excluded is compared by these. `calibration`: parameters that were free.
[[nodiscard]] AdjustmentRecord record_of(const Adjustment& adjustment, const OrientationRecord& orientation,
                                         const Block& setup, Calibration calibration);

/// Covariances as the store keeps them, points in the order of the block.
[[nodiscard]] BlockCovariances covariances_of(const Adjustment& adjustment);

}  // namespace collinea
