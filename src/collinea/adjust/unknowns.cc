// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/unknowns.h"

namespace collinea {
namespace {

// As the observations of it call it.
std::string name_of_shape(const Block& block, GroundKind kind, std::uint32_t number) {
  for (const GroundObservation& one : block.ground)
    if (one.kind == kind && one.setup == number && !one.name.empty()) return one.name;
  return std::to_string(number + 1);
}

}  // namespace

std::string name_of_extra(const Block& block, UnknownKind kind, std::uint32_t owner, int axis) {
  constexpr const char* kInWorld[] = {"east", "north", "height"};
  constexpr const char* kInCamera[] = {"to the right", "downwards", "along the axis"};
  constexpr const char* kTurns[] = {"about its x axis", "about its y axis", "about its optical axis"};
  const auto camera = [&] { return block.cameras.at(CameraId{owner}).name; };
  switch (kind) {
    case UnknownKind::kOrientation:
      return "the orientation of set-up " + std::to_string(owner + 1);
    case UnknownKind::kLeverArm:
      return std::string("the lever arm ") + kInCamera[axis] + " of " + camera();
    case UnknownKind::kShift:
      return std::string("the shift of positions in ") + kInWorld[axis] + " of strip " + std::to_string(owner + 1);
    case UnknownKind::kDrift:
      return std::string("the drift of positions in ") + kInWorld[axis] + " of strip " + std::to_string(owner + 1);
    case UnknownKind::kBoresight:
      return std::string("the boresight ") + kTurns[axis] + " of " + camera();
    case UnknownKind::kTimeOffset:
      return "the time offset of the positions of " + camera();
    case UnknownKind::kHeight:
      return "the height " + name_of_shape(block, GroundKind::kAtHeight, owner);
    case UnknownKind::kPlane:
      return (axis == 0 ? "the place of plane " : "the tilt of plane ") +
             name_of_shape(block, GroundKind::kOnPlane, owner);
    case UnknownKind::kLine:
      return (axis % 2 == 0 ? "the place of line " : "the direction of line ") +
             name_of_shape(block, GroundKind::kOnLine, owner);
  }
  return "";
}

}  // namespace collinea
