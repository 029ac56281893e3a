// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/orient/adjustment_options.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// An adjustment, and what the next one begins with.
struct TakingUp {
  const Examined& adjusted;
  Block& block;
  AdjustScope& scope;
  InstrumentOptions& instruments;
  std::vector<Finding>& taken_up;  ///< what is estimated without having been asked for
};

/// The strongest systematic error that is beyond doubt takes part in the next adjustment: of an instrument, or where
/// there is none a deformation of the images of a camera that is calibrated, unless `asked` says what cameras have.
/// Adds to TakingUp::taken_up, and gives block and scope what the next adjustment needs, which begins at this one.
/// False: there is none. Errors: those of add_instruments().
[[nodiscard]] Result<bool> take_up_systematics(const AdjustmentOptions& asked, Calibration calibration, TakingUp done);

}  // namespace collinea
