// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/block/block.h"

namespace collinea {

/// What was measured on the ground, in words: "distance A - B (tape 3)", "P7 on plane wall", "P7 on line kerb,
/// sideways".
[[nodiscard]] inline std::string words_of(const GeodeticObservation& measured, const Block& block) {
  const std::string kind = kGeodeticKindNames[static_cast<std::size_t>(measured.kind)];
  const std::string& from = block.control.at(measured.from).name;
  if (!measured.is_of_shape())
    return kind + " " + from + " - " + block.control.at(measured.to).name +
           (measured.name.empty() ? "" : " (" + measured.name + ")");
  std::string text = from + (measured.kind == GeodeticKind::kAtHeight ? " at " : " on ") + kind + " " +
                     (measured.name.empty() ? std::to_string(measured.setup + 1) : measured.name);
  if (measured.kind == GeodeticKind::kOnLine) text += measured.axis == 0 ? ", sideways" : ", upwards";
  return text;
}

}  // namespace collinea
