// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>

#include "collinea/block/block.h"

namespace collinea {

/// What was measured on the ground, in words: "distance A - B (tape 3)", "P7 on plane wall", "P7 on line kerb,
/// sideways", "GNSS vector A - B along x y z 0.71 0.70 0.02".
[[nodiscard]] inline std::string words_of(const GeodeticObservation& measured, const Block& block) {
  const std::string kind = kGeodeticKindNames[static_cast<std::size_t>(measured.kind)];
  const std::string& from = block.control.at(measured.from).name;
  if (measured.kind == GeodeticKind::kGnssVector)
    return fmt::format("{} {} - {}{} along {} {:.2f} {:.2f} {:.2f}", kind, from, block.control.at(measured.to).name,
                       measured.name.empty() ? "" : " (" + measured.name + ")", measured.is_local ? "e n u" : "x y z",
                       measured.along.x(), measured.along.y(), measured.along.z());
  if (!measured.is_of_shape())
    return kind + " " + from + " - " + block.control.at(measured.to).name +
           (measured.name.empty() ? "" : " (" + measured.name + ")");
  std::string text = from + (measured.kind == GeodeticKind::kAtHeight ? " at " : " on ") + kind + " " +
                     (measured.name.empty() ? std::to_string(measured.setup + 1) : measured.name);
  if (measured.kind == GeodeticKind::kOnLine) text += measured.axis == 0 ? ", sideways" : ", upwards";
  return text;
}

}  // namespace collinea
