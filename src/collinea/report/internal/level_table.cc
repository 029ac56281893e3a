// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/internal/level_table.h"

#include <fmt/format.h>

namespace collinea {

std::string level_table(std::span<const LevelCount> levels) {
  std::string text = fmt::format("  {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>13}\n", "size", "threshold", "interest",
                                 "matched", "grown", "spikes", "searched[px]");
  for (const LevelCount& level : levels)
    text += fmt::format("  {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>13.1f}{}\n", fmt::format("1/{}", level.shrink),
                        level.threshold > 0 ? fmt::format("{:.0f}", level.threshold) : "grid", level.interest,
                        level.matched, level.grown, level.spikes, level.median_interval_px,
                        level.is_dropped ? "  dropped: too few points" : "");
  return text;
}

}  // namespace collinea
