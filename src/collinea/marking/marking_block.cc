// SPDX-License-Identifier: Apache-2.0
#include "collinea/marking/marking_block.h"

namespace collinea {

std::map<ImageId, std::vector<std::size_t>> observations_by_image(const Block& block) {
  std::map<ImageId, std::vector<std::size_t>> all;
  for (std::size_t i = 0; i < block.observations.size(); ++i) all[block.observations[i].image].push_back(i);
  return all;
}

bool is_hidden(const SurfaceHeight& surface, const Eigen::Vector3d& position, const Eigen::Vector3d& centre) {
  if (!surface) return false;
  constexpr int kSteps = 200;
  constexpr double kPart = 0.01;  // of the distance in plan
  const Eigen::Vector3d way = centre - position;
  for (int i = 4; i < kSteps; ++i) {
    const double t = double(i) / kSteps;
    const Eigen::Vector3d at = position + t * way;
    const auto height = surface(at.head<2>());
    if (height && *height > at.z() + kPart * t * way.norm()) return true;
  }
  return false;
}

}  // namespace collinea
