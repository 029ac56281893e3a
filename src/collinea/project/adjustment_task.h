// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/orient/adjustment.h"
#include "collinea/project/project.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// How the oriented block of a project is adjusted.
struct ProjectAdjustment {
  AdjustmentTask task;
  OrientationRecord orientation;  ///< how the block was found
};

/// Begins at what orientation left, whatever was adjusted since: the same options give the same adjustment. Control and
/// positions take part as they did there, with what was found of them. Notes say what differs from what was given.
/// Errors: not oriented yet; options; instruments that the block has not.
[[nodiscard]] Result<ProjectAdjustment> adjustment_of(const Project& project, const AdjustmentOptions& asked);

/// The same where the adjustment of the project ended: with cameras (and how film is deformed), poses, points and
/// measurements as that left them (`adjusted`, as the store has it), with the sigmas and instruments that it found.
/// What data snooping did to what was given is not recorded. Errors: not adjusted yet; as above.
[[nodiscard]] Result<ProjectAdjustment> adjustment_in_force(const Project& project, const Block& adjusted);

/// How points that are marked are adjusted with the block: as adjustment_of(); where scans of film take part as
/// adjustment_in_force(), for how film is deformed follows from an adjustment. Errors: as these.
[[nodiscard]] Result<ProjectAdjustment> adjustment_with_marks(const Project& project);

/// Options of the adjustment that hold for projects and files alike. `calibration`: of cameras that do not say it
/// themselves.
[[nodiscard]] ExamineOptions examine_options(const AdjustmentOptions& asked, Calibration calibration);

/// What is examined for gross errors: what was asked for, or else `by_default`.
[[nodiscard]] std::optional<SnoopedKinds> snooped_kinds(const AdjustmentOptions& asked,
                                                        std::optional<SnoopedKinds> by_default);

}  // namespace collinea
