// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/info.h"

#include <cmath>

namespace collinea {

const OrientationRecord* ProjectInfo::orientation() const {
  for (const StepRecord& step : steps)
    if (const auto* record = std::get_if<OrientationRecord>(&step.outcome)) return record;
  return nullptr;
}

Result<ProjectInfo> project_info(const ProjectStore& store) {
  ProjectInfo info;
  COLLINEA_TRY(info.setup, store.read_setup());
  COLLINEA_TRY(info.steps, store.read_steps());
  return info;
}

bool is_beyond_3_sigma(const ControlDifference& control) {
  for (int axis = 0; axis < 3; ++axis)  // false where one of them is not known
    if (std::abs(control.difference_m[axis]) > 3 * control.difference_sigma_m[axis]) return true;
  return false;
}

}  // namespace collinea
