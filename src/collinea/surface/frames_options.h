// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"

namespace collinea {

/// Which planes of the object become frames of products beside the map.
enum class FrameChoice { kAuto, kMap, kPlanes };
inline constexpr Word<FrameChoice> kFrameChoiceWords[] = {
    {FrameChoice::kAuto, "auto", "planes where the images do not look down"},
    {FrameChoice::kMap, "map", "none but the map"},
    {FrameChoice::kPlanes, "planes", "upright and slanting planes of the cloud"}};
[[nodiscard]] constexpr std::span<const Word<FrameChoice>> words(FrameChoice) { return kFrameChoiceWords; }

struct FramesOptions {
  WordOr<FrameChoice, std::filesystem::path> frames = FrameChoice::kAuto;
  std::optional<double> tolerance_m, depth_m, cell_m;
  std::optional<double> scale;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = FramesOptions;
    visit(Field{"frames", &O::frames, "",
                "planes that surface and orthophoto are made on as on the ground: auto (planes where the images do not "
                "look down) | map (none) | planes (upright and slanting ones of the cloud) | a file with a name and "
                "easting, northing, height in each line: three points or more of each plane"}
              .leads_to(PathKind::kFileOrWord));
    visit(Field{"tolerance_m", &O::tolerance_m, "m",
                "largest distance of a plane's points from it; else three median standard deviations of the cloud or a "
                "two-hundredth of its extent",
                1e-6, 1e6});
    visit(Field{"depth_m", &O::depth_m, "m",
                "what lies so far before and behind a plane is shown on it; else by tolerance and extent", 1e-6, 1e6});
    visit(Field{"cell_m", &O::cell_m, "m",
                "cell of surface and orthophoto; else the size of a matched pixel and of a pixel", 1e-6});
    visit(Field{"scale", &O::scale, "",
                "number of the scale of the drawing, 50 for 1:50; else the largest that fits on A3", 0.1, 1e6});
  }
};

}  // namespace collinea
