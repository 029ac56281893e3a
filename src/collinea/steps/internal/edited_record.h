// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/edit/make_edits.h"
#include "collinea/project/project.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// What an import said of the control, as it is once edits were made: points that they added, marked and removed, and
/// the edits that do not fit what was imported (`unfit`).
[[nodiscard]] Result<ImportRecord> with_edits(ImportRecord record, const ProjectStore& store,
                                              const std::vector<UnfitEdit>& unfit);

/// Brings the record of an import that is done up to the edits made since.
[[nodiscard]] Result<> renew_import_record(Project& project, const EditHistory& history);

}  // namespace collinea
