// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// The part of a setup that people change by hand.
struct EditedControl {
  std::map<ControlId, ControlPoint> control;
  std::vector<ControlObservation> control_observations;
  std::uint64_t last_edit = 0;  ///< number of the last edit in it; 0: as it was imported
};

/// A setup as it was imported, and what edits have made of its control. Without edits the two are the same.
struct EditableSetup {
  Block imported;  ///< georeference, cameras, images, control with its observations, what was measured on the ground
  EditedControl edited;
};

/// What the control shall be from now on; an error leaves everything as it is. Must not use the store.
using EditControl = std::function<Result<EditedControl>(const EditableSetup& setup)>;

}  // namespace collinea
