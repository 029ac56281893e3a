// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/internal/better_start.h"

#include <cmath>
#include <map>
#include <string>

#include "collinea/models/anblock.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

// Means of what the models that take part say of each point.
std::map<std::string, Vector3d> means_of(const std::vector<StereoModel>& models, const ModelChain& chain) {
  std::map<std::string, Vector3d> sums;
  std::map<std::string, int> counts;
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (!chain.ground_from_model[m]) continue;
    for (const NamedPoint& point : models[m].points) {
      sums.try_emplace(point.name, Vector3d::Zero()).first->second += *chain.ground_from_model[m] * point.position;
      ++counts[point.name];
    }
  }
  for (auto& [name, sum] : sums) sum /= counts[name];
  return sums;
}

// Squares of what models and control differ by from the means, on the ground.
double disagreement(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
                    const ModelChain& chain) {
  double squares = 0;
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (!chain.ground_from_model[m]) continue;
    for (const NamedPoint& point : models[m].points)
      squares += (*chain.ground_from_model[m] * point.position - chain.points.at(point.name)).squaredNorm();
  }
  for (const SurveyedPoint& point : control) {
    const auto found = chain.points.find(point.name);
    for (int axis = 0; axis < 3 && found != chain.points.end(); ++axis)
      if (!point.is_check && point.has(axis)) squares += std::pow(point.position[axis] - found->second[axis], 2);
  }
  return squares;
}

}  // namespace

ModelChain better_start(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
                        ModelChain chain, const Run& run) {
  if (!chain.on_ground) return chain;
  std::vector<StereoModel> level = models;
  std::vector<bool> used;
  for (std::size_t m = 0; m < models.size(); ++m) {
    used.push_back(chain.ground_from_model[m].has_value());
    if (used.back()) level[m] = levelled(level[m], chain.ground_from_model[m]->rotation);
  }
  AnblockOptions roughly;
  roughly.settled = 10;
  roughly.most_cycles = 50;
  const auto joined = anblock(level, used, control, roughly, run);
  if (!joined) return chain;
  ModelChain other = chain;
  for (std::size_t m = 0; m < models.size(); ++m) {
    if (!used[m]) continue;
    const Similarity3& from_level = joined->models[m]->ground_from_model;
    other.ground_from_model[m] =
        Similarity3{from_level.scale, (from_level.rotation * chain.ground_from_model[m]->rotation).normalized(),
                    from_level.translation};
  }
  other.points = means_of(models, other);
  return disagreement(models, control, other) < disagreement(models, control, chain) ? other : chain;
}

}  // namespace collinea
