// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "collinea/base/words.h"

namespace collinea {

/// What tells how a block lies level where positions and control do not.
enum class LevelSource : std::uint8_t {
  kNone,
  kAttitudes,   ///< that the camera wrote
  kEdges,       ///< horizontal edges of the images
  kView,        ///< the mean view is taken as down
  kLowerEdges,  ///< the mean lower edge of the images is taken as down
};
inline constexpr Word<LevelSource> kLevelSourceWords[] = {{LevelSource::kNone, "none"},
                                                          {LevelSource::kAttitudes, "attitudes"},
                                                          {LevelSource::kEdges, "edges"},
                                                          {LevelSource::kView, "view"},
                                                          {LevelSource::kLowerEdges, "lower_edges"}};
[[nodiscard]] constexpr std::span<const Word<LevelSource>> words(LevelSource) { return kLevelSourceWords; }

/// What of the positions of images fixes a block.
enum class PositionUse : std::uint8_t {
  kSpace,
  kPlan,    ///< they have no heights
  kOnLine,  ///< attitudes fix the rotation about their line
};
inline constexpr Word<PositionUse> kPositionUseWords[] = {
    {PositionUse::kSpace, "space"}, {PositionUse::kPlan, "plan"}, {PositionUse::kOnLine, "on_line"}};
[[nodiscard]] constexpr std::span<const Word<PositionUse>> words(PositionUse) { return kPositionUseWords; }

/// What fixes position, attitude and scale of an oriented block. As it stands: nothing; the unit is the first base, z
/// is up as images are held.
struct Gauge {
  std::string map;              ///< its coordinate reference system; empty: a local frame without position on Earth
  std::string given_by;         ///< file or folder of the poses that the block keeps; empty: none
  bool by_control = false;      ///< control points
  std::uint64_t positions = 0;  ///< of images that take part
  PositionUse position_use = PositionUse::kSpace;
  LevelSource level = LevelSource::kNone;
  std::uint64_t distances = 0;  ///< that fix the scale of a block without position on Earth

  friend bool operator==(const Gauge&, const Gauge&) = default;

  template <class Visit>
  static void fields(Visit&& visit) {
    visit("map", &Gauge::map);
    visit("given_by", &Gauge::given_by);
    visit("by_control", &Gauge::by_control);
    visit("positions", &Gauge::positions);
    visit("position_use", &Gauge::position_use);
    visit("level", &Gauge::level);
    visit("distances", &Gauge::distances);
  }
};

}  // namespace collinea
