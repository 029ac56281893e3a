// SPDX-License-Identifier: Apache-2.0
#include "collinea/geometry/internal/absolute_starts.h"

#include <array>
#include <cmath>
#include <numbers>

namespace collinea {
namespace {

using Eigen::Vector3d;

Similarity3 about(const ReducedControl& reduced, double scale, const Eigen::Quaterniond& rotation) {
  Similarity3 start{scale, rotation.normalized(), Vector3d::Zero()};
  start.translation = reduced.ground - start * reduced.model;
  return start;
}

// The two indices that are farthest apart in the model, of those that pass.
template <class Passes>
std::array<std::size_t, 2> farthest(std::span<const AbsoluteControl> pairs, const Passes& passes) {
  std::array<std::size_t, 2> best{0, 0};
  double longest = -1;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    for (std::size_t j = i + 1; j < pairs.size(); ++j)
      if (passes(pairs[i]) && passes(pairs[j]))
        if (const double length = (pairs[j].in_model - pairs[i].in_model).norm(); length > longest) {
          longest = length;
          best = {i, j};
        }
  return best;
}

// Where two full points are given: all rotations about their line, in steps.
std::vector<Similarity3> starts_about_line(std::span<const AbsoluteControl> pairs) {
  constexpr int kSteps = 12;
  const auto [i, j] = farthest(pairs, [](const AbsoluteControl& pair) { return pair.is_full(); });
  const Vector3d model = pairs[j].in_model - pairs[i].in_model, ground = pairs[j].in_ground - pairs[i].in_ground;
  if (!(model.norm() > 0 && ground.norm() > 0)) return {};
  const Eigen::Quaterniond onto = Eigen::Quaterniond::FromTwoVectors(model, ground);
  std::vector<Similarity3> starts;
  for (int k = 0; k < kSteps; ++k) {
    const Eigen::AngleAxisd spin(2 * std::numbers::pi * k / kSteps, ground.normalized());
    Similarity3 start{ground.norm() / model.norm(), (spin * onto).normalized(), Vector3d::Zero()};
    start.translation = pairs[i].in_ground - start * pairs[i].in_model;
    starts.push_back(start);
  }
  return starts;
}

// A model whose w axis is upright: the similarity of the plan alone.
std::vector<Similarity3> level_start(std::span<const AbsoluteControl> pairs, const ReducedControl& reduced) {
  const auto [i, j] = farthest(pairs, [](const AbsoluteControl& pair) { return pair.has_plan; });
  const Eigen::Vector2d model = (pairs[j].in_model - pairs[i].in_model).head<2>();
  const Eigen::Vector2d ground = (pairs[j].in_ground - pairs[i].in_ground).head<2>();
  if (!(model.norm() > 0 && ground.norm() > 0)) return {};
  const double kappa = std::atan2(ground.y(), ground.x()) - std::atan2(model.y(), model.x());
  return {
      about(reduced, ground.norm() / model.norm(), Eigen::Quaterniond(Eigen::AngleAxisd(kappa, Vector3d::UnitZ())))};
}

}  // namespace

ReducedControl reduced_control(std::span<const AbsoluteControl> pairs) {
  ReducedControl mean;
  double plan = 0, height = 0;
  for (const AbsoluteControl& pair : pairs) {
    mean.model += pair.in_model / double(pairs.size());
    if (pair.has_plan) {
      mean.ground.head<2>() += pair.in_ground.head<2>();
      plan += 1;
    }
    if (pair.has_height) {
      mean.ground.z() += pair.in_ground.z();
      height += 1;
    }
  }
  if (plan > 0) mean.ground.head<2>() /= plan;
  if (height > 0) mean.ground.z() /= height;
  return mean;
}

std::vector<Similarity3> absolute_starts(std::span<const AbsoluteControl> pairs, const ReducedControl& reduced) {
  std::vector<Vector3d> model, ground;
  for (const AbsoluteControl& pair : pairs)
    if (pair.is_full()) {
      model.push_back(pair.in_model);
      ground.push_back(pair.in_ground);
    }
  if (const auto aligned = align(model, ground); aligned && aligned->scale > 0) return {*aligned};
  if (model.size() >= 2) return starts_about_line(pairs);
  return level_start(pairs, reduced);
}

}  // namespace collinea
