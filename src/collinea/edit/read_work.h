// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/result.h"
#include "collinea/block/image_masks.h"
#include "collinea/edit/edited_work.h"
#include "collinea/edit/unfit_edit.h"
#include "collinea/project/project.h"

namespace collinea {

/// What the journal of a project says beside control. `unfit` (may be null) takes edits that do not fit. Errors: the
/// journal or the setup cannot be read.
[[nodiscard]] Result<EditedWork> read_work(const Project& project, std::vector<UnfitEdit>* unfit = nullptr);

/// The regions of the cloud that were edited, in the order of the edits. Errors: the journal cannot be read.
[[nodiscard]] Result<std::vector<CloudRegion>> read_cloud_regions(const Project& project);
[[nodiscard]] Result<CloudEdits> read_cloud_edits(const Project& project);

/// The masks of a work.
[[nodiscard]] ImageMasks masks_of(const EditedWork& work);
/// Those of a project.
[[nodiscard]] Result<ImageMasks> read_masks(const Project& project);

}  // namespace collinea
