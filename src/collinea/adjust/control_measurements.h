// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "collinea/adjust/control_check.h"
#include "collinea/adjust/intersect.h"

namespace collinea::bundle {

/// Intersects every control and check point without its wrong measurements, which go into the diagnosis. Answers the
/// points that were found, in the block's frame.
std::map<ControlId, Intersection> intersect_control(const Block& block, ControlDiagnosis& diagnosis);

}  // namespace collinea::bundle
