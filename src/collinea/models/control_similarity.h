// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "collinea/geometry/similarity3.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

/// A surveyed point beside where it lies in a model or a chain of models.
struct ControlPair {
  Eigen::Vector3d in_model = Eigen::Vector3d::Zero();
  Eigen::Vector3d on_ground = Eigen::Vector3d::Zero();
  std::array<bool, 3> has = {true, true, true};  ///< which ground coordinates are given
};

/// How far a set of surveyed coordinates fixes a similarity of seven parameters.
struct ControlRank {
  int plan = 0, heights = 0;  ///< points with a position in plan; with a height
  int rank = 0;               ///< 7: all is fixed
};
[[nodiscard]] ControlRank rank_of(const std::vector<ControlPair>& pairs, const Similarity3& ground_from_model);

/// Approximate absolute orientation by whatever control there is, full, plan or height (2 + 1 points at least): least
/// squares of the seven parameters, all coordinates with one weight, from many starting rotations, so that no attitude
/// is assumed. Where two attitudes fit alike (a block about the line of its only two plan points can lie on its back)
/// the one with the model's w axis more upward is taken. Nothing: seven parameters are not determined.
[[nodiscard]] std::optional<Similarity3> control_similarity(const std::vector<ControlPair>& pairs);

}  // namespace collinea
