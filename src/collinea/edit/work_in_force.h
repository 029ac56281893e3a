// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/edit/edit_history.h"
#include "collinea/edit/edited_point.h"
#include "collinea/edit/edited_work.h"
#include "collinea/edit/unfit_edit.h"

namespace collinea {

/// The work that the edits in force make, one after the other. `unfit` (may be null) takes those that do not fit what
/// there is: they are left out.
[[nodiscard]] EditedWork work_in_force(const EditContext& context, const EditHistory& history,
                                       std::vector<UnfitEdit>* unfit = nullptr);

/// Its regions of the cloud alone, which need nothing of the setup.
[[nodiscard]] std::vector<CloudRegion> cloud_regions_in_force(const EditHistory& history);

}  // namespace collinea
