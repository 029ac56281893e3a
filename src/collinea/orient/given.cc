// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/given.h"

#include <cmath>
#include <vector>

#include "collinea/epipolar/intersect.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kAgrees = 5;  // sigmas: systematic errors of receivers are in it
constexpr std::size_t kLeastControl = 3;

// The difference in sigmas, over the axes that were measured; nothing when none was.
std::optional<double> in_sigmas(const Eigen::Vector3d& difference_m, const Eigen::Vector3d& sigma_m) {
  double squares = 0;
  int count = 0;
  for (int axis = 0; axis < 3; ++axis)
    if (std::isfinite(sigma_m[axis])) {
      squares += std::pow(difference_m[axis] / sigma_m[axis], 2);
      ++count;
    }
  if (count == 0) return std::nullopt;
  return std::sqrt(squares / count);
}

bool most_agree(std::vector<double> differences) { return median(differences) < kAgrees; }

}  // namespace

bool lies_in_world(const Block& block) {
  std::vector<double> control, positions;
  for (const auto& [id, point] : block.control) {
    if (point.role != ControlRole::kControl) continue;
    const auto met = intersect(sight_lines(block, id));
    if (!met) continue;
    if (const auto off = in_sigmas(met->point_in_world - point.position_in_world, point.sigma_m))
      control.push_back(*off);
  }
  if (control.size() >= kLeastControl) return most_agree(control);
  for (const auto& [id, pose] : oriented_images(block))
    if (const auto& position = block.images.at(id).position)
      if (const auto off = in_sigmas(centre_of(pose) - position->position_in_world, position->sigma_m))
        positions.push_back(*off);
  return !positions.empty() && most_agree(positions);
}

}  // namespace collinea
