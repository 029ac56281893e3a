// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/info.h"

#include <cmath>

namespace collinea {

namespace {

template <class Record>
const Record* record_in(const std::vector<StepRecord>& steps) {
  for (const StepRecord& step : steps)
    if (const auto* record = std::get_if<Record>(&step.outcome)) return record;
  return nullptr;
}

}  // namespace

const OrientationRecord* ProjectInfo::orientation() const { return record_in<OrientationRecord>(steps); }
const AdjustmentRecord* ProjectInfo::adjustment() const { return record_in<AdjustmentRecord>(steps); }

Result<ProjectInfo> project_info(const ProjectStore& store) {
  ProjectInfo info;
  COLLINEA_TRY(info.setup, store.read_setup_for_names());
  for (const Word<Step>& step : kStepWords) {
    auto record = store.read_step(std::string(step.word));
    if (!record && record.error().code == Errc::kUnsupported)
      info.by_another_version.push_back(step.value);
    else if (!record)
      return tl::unexpected(std::move(record).error());
    else if (*record)
      info.steps.push_back(**std::move(record));
  }
  return info;
}

bool is_beyond_3_sigma(const ControlDifference& control) {
  for (int axis = 0; axis < 3; ++axis)  // false where one of them is not known
    if (std::abs(control.difference_m[axis]) > 3 * control.difference_sigma_m[axis]) return true;
  return false;
}

}  // namespace collinea
