// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/orient/adjustment.h"

namespace collinea {

/// The strongest systematic error that is beyond doubt takes part in the next adjustment: of an instrument, or where
/// there is none a deformation of the images of a camera that is calibrated, unless `asked` says what cameras have.
/// Adds to Adjustment::taken_up, and gives block and scope what the next adjustment needs, which begins at this one.
/// False: there is none. Errors: those of add_instruments().
[[nodiscard]] Result<bool> take_up_systematics(const AdjustmentOptions& asked, Calibration calibration,
                                               Adjustment& done);

}  // namespace collinea
