// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "collinea/restitution/ground_match.h"
#include "collinea/restitution/stereo_pairs.h"

namespace collinea {

/// A place measured in stereo.
struct GroundReport {
  std::array<std::string, 2> files;  ///< of the pair
  StereoChoice pair;
  GroundMatch match;
  Eigen::Vector3d position;                ///< in the map
  std::optional<Eigen::Vector3d> sigma_m;  ///< of it, by the match and the poses; nothing: poses are not known
  struct Other {
    std::array<std::string, 2> files;
    StereoChoice pair;
  };
  std::vector<Other> others;  ///< all pairs that show the place, best first
};

[[nodiscard]] std::string ground_text(const GroundReport& report);

}  // namespace collinea
