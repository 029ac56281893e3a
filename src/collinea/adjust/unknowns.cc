// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/unknowns.h"

namespace collinea {

Subject subject_of(UnknownKind kind, std::uint32_t owner, int axis) {
  switch (kind) {
    case UnknownKind::kOrientation:
      return {SubjectKind::kSetup, owner, Aspect::kOrientation};
    case UnknownKind::kLeverArm:
      return {SubjectKind::kCamera, owner, Aspect::kLeverArm, axis};
    case UnknownKind::kShift:
      return {SubjectKind::kStrip, owner, Aspect::kShift, axis};
    case UnknownKind::kDrift:
      return {SubjectKind::kStrip, owner, Aspect::kDrift, axis};
    case UnknownKind::kBoresight:
      return {SubjectKind::kCamera, owner, Aspect::kBoresight, axis};
    case UnknownKind::kTimeOffset:
      return {SubjectKind::kCamera, owner, Aspect::kTimeOffset};
    case UnknownKind::kHeight:
      return {SubjectKind::kLevel, owner, Aspect::kHeight};
    case UnknownKind::kPlane:
      return {SubjectKind::kPlane, owner, axis == 0 ? Aspect::kPosition : Aspect::kTilt};
    case UnknownKind::kLine:
      return {SubjectKind::kLine, owner, axis % 2 == 0 ? Aspect::kPosition : Aspect::kDirection};
  }
  return {};
}

}  // namespace collinea
