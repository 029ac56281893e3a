// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "collinea/base/words.h"

namespace collinea {

/// The forms of a cloud in the map: plain; compressed; compressed and sorted into an octree, so that programs read what
/// they show. The same records in all of them.
enum class LasForm { kLas, kLaz, kCopc };
inline constexpr Word<LasForm> kLasFormWords[] = {
    {LasForm::kLas, "las"},
    {LasForm::kLaz, "laz", "a sixth of the size, no loss"},
    {LasForm::kCopc, "copc", "laz sorted into an octree, of which viewers load what they show"}};
[[nodiscard]] constexpr std::span<const Word<LasForm>> words(LasForm) { return kLasFormWords; }

}  // namespace collinea
