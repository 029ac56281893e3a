// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>

#include "collinea/epipolar/intersect.h"
#include "collinea/quality/internal/control_diagnosis.h"

namespace collinea::bundle {

/// Intersects every control and check point without its wrong measurements, which go into the diagnosis. Answers the
/// points that were found, in the block's frame.
std::map<ControlId, Intersection> intersect_control(const Block& block, ControlDiagnosis& diagnosis);

}  // namespace collinea::bundle
