// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/read_work.h"

#include <algorithm>

#include "collinea/edit/journal.h"
#include "collinea/edit/work_in_force.h"

namespace collinea {

Result<EditedWork> read_work(const Project& project, std::vector<UnfitEdit>* unfit) {
  Journal journal(project.folder);
  COLLINEA_TRY(journal.refresh());
  const auto is_of_work = [](const EditEntry& entry) {
    return std::visit([](const auto& kind) { return EditsWork<std::decay_t<decltype(kind)>>; }, entry.edit);
  };
  if (std::ranges::none_of(journal.history().entries(), is_of_work)) return EditedWork{};
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  return work_in_force(EditContext(setup), journal.history(), unfit);
}

Result<std::vector<CloudRegion>> read_cloud_regions(const Project& project) {
  Journal journal(project.folder);
  COLLINEA_TRY(journal.refresh());
  return cloud_regions_in_force(journal.history());
}

Result<CloudEdits> read_cloud_edits(const Project& project) {
  return read_cloud_regions(project).map([](std::vector<CloudRegion> regions) { return CloudEdits(std::move(regions)); });
}

ImageMasks masks_of(const EditedWork& work) {
  ImageMasks masks;
  for (const ImageMask& one : work.masks) masks.add(one.image, one.ring_px);
  return masks;
}

Result<ImageMasks> read_masks(const Project& project) {
  return read_work(project).map([](const EditedWork& work) { return masks_of(work); });
}

}  // namespace collinea
