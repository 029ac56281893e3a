// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/steps/step_list.h"
#include "collinea/store/project_store.h"

namespace collinea {

/// What is known of a project.
struct ProjectInfo {
  Block setup;                    ///< before orientation
  std::vector<StepRecord> steps;  ///< those that are done, in the order of work
  std::vector<Step> by_another_version;  ///< done by a version of the program whose records this one cannot read

  /// Null: not oriented yet.
  [[nodiscard]] const OrientationRecord* orientation() const;
  /// Null: not adjusted yet.
  [[nodiscard]] const AdjustmentRecord* adjustment() const;
};

[[nodiscard]] Result<ProjectInfo> project_info(const ProjectStore& store);

/// Whether a difference at a control or check point is larger than three times its predicted standard deviation, on any
/// axis.
[[nodiscard]] bool is_beyond_3_sigma(const ControlDifference& control);

}  // namespace collinea
