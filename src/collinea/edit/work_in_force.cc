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

}  // namespace collinea
