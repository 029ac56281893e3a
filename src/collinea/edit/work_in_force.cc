// SPDX-License-Identifier: Apache-2.0
#include "collinea/edit/work_in_force.h"

#include <type_traits>

namespace collinea {

EditedWork work_in_force(const EditContext& context, const EditHistory& history, std::vector<UnfitEdit>* unfit) {
  EditedWork work;
  for (const EditEntry& entry : history.entries()) {
    if (!entry.is_in_force()) continue;
    const Result<> applied = std::visit(
        [&](const auto& kind) -> Result<> {
          if constexpr (EditsWork<std::decay_t<decltype(kind)>>) return kind.apply(context, work);
          return {};
        },
        entry.edit);
    if (!applied && unfit) unfit->push_back({entry.number, {}, line_of(words_of(entry.edit)), applied.error()});
  }
  return work;
}

std::vector<CloudRegion> cloud_regions_in_force(const EditHistory& history) {
  std::vector<CloudRegion> regions;
  for (const EditEntry& entry : history.entries())
    if (entry.is_in_force())
      std::visit(
          [&](const auto& kind) {
            if constexpr (std::is_base_of_v<EditsCloud, std::decay_t<decltype(kind)>>) regions.push_back(kind.region);
          },
          entry.edit);
  return regions;
}

}  // namespace collinea
