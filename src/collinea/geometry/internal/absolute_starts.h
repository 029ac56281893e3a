// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "collinea/geometry/absolute_control.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// Both sides of the control reduced to a point among it, so that large coordinates cost no digits.
struct ReducedControl {
  Eigen::Vector3d model = Eigen::Vector3d::Zero(), ground = Eigen::Vector3d::Zero();
};
[[nodiscard]] ReducedControl reduced_control(std::span<const AbsoluteControl> pairs);

/// From where an absolute orientation begins: by the full points where three of them are not on a line, else by all
/// rotations about the line of two, in steps, else as if the model's w axis were upright. Nothing where points
/// coincide.
[[nodiscard]] std::vector<Similarity3> absolute_starts(std::span<const AbsoluteControl> pairs,
                                                       const ReducedControl& reduced);

}  // namespace collinea
