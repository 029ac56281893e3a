// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/datum.h"

#include <cmath>

#include "collinea/epipolar/intersect.h"
#include "collinea/geometry/robust_similarity.h"

namespace collinea {
namespace {

using bundle::PositionPair;

std::vector<PositionPair> control_pairs(const Block& block, std::vector<ControlId>& points) {
  std::vector<PositionPair> pairs;
  for (const auto& [id, control] : block.control) {
    if (control.role != ControlRole::kControl || !control.sigma_m.allFinite()) continue;
    const auto met = intersect(sight_lines(block, id));
    if (!met) continue;
    pairs.push_back({met->point_in_world, control.position_in_world, std::sqrt(control.sigma_m.squaredNorm() / 3)});
    points.push_back(id);
  }
  return pairs;
}

}  // namespace

std::vector<PositionPair> position_pairs(const Block& block, std::vector<ImageId>& images) {
  std::vector<PositionPair> pairs;
  for (const auto& [id, pose] : oriented_images(block)) {
    const auto& position = block.images.at(id).position;
    if (!position || !position->sigma_m.allFinite()) continue;
    const double sigma = std::sqrt(position->sigma_m.squaredNorm() / 3);
    pairs.push_back({centre_of(pose), position->position_in_world, sigma});
    images.push_back(id);
  }
  return pairs;
}

std::optional<Datum> datum(const Block& block, bool use_positions, bool use_control, std::uint64_t seed) {
  Datum result;
  std::vector<ControlId> points;
  std::vector<ImageId> images;
  std::vector<PositionPair> pairs;
  if (use_control) pairs = control_pairs(block, points);
  result.by_control = bundle::span_a_plane(pairs);
  if (!result.by_control && use_positions) {
    const std::vector<PositionPair> positions = position_pairs(block, images);
    pairs.insert(pairs.end(), positions.begin(), positions.end());
  }
  if (!bundle::span_a_plane(pairs)) return std::nullopt;
  const auto fit = bundle::robust_similarity(pairs, seed);
  if (!fit) return std::nullopt;
  result.world_from_block = fit->world_from_block;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (fit->weights[i] == 0) continue;
    if (i < points.size())
      result.control.push_back(points[i]);
    else
      result.images.push_back(images[i - points.size()]);
  }
  return result;
}

}  // namespace collinea
