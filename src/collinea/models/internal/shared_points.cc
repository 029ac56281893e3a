// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/internal/shared_points.h"

#include <algorithm>

#include "collinea/math/ordering.h"

namespace collinea {
namespace {

constexpr int kPointsOfTile = bundle::kTile / 3;

// Points are neighbours that one model shows.
bundle::Covisibility neighbours(const std::vector<std::vector<int>>& numbers, std::size_t count) {
  bundle::Covisibility graph(count);
  for (const std::vector<int>& model : numbers)
    for (const int one : model)
      for (const int other : model)
        if (one >= 0 && other >= 0 && one != other) graph[static_cast<std::size_t>(one)].push_back(other);
  for (auto& others : graph) {
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
  return graph;
}

}  // namespace

SharedPoints::SharedPoints(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
                           const ModelChain& chain)
    : numbers_(models.size()) {
  std::map<std::string, int> times;
  for (std::size_t m = 0; m < models.size(); ++m)
    if (chain.ground_from_model[m])
      for (const NamedPoint& point : models[m].points) ++times[point.name];
  for (const SurveyedPoint& point : control)
    if (!point.is_check && times.contains(point.name)) ++times[point.name];
  std::vector<Eigen::Vector3d> positions;
  for (const auto& [name, count] : times)
    if (count > 1) {
      number_of_[name] = static_cast<int>(names_.size());
      names_.push_back(name);
      positions.push_back(chain.points.at(name));
    }
  const auto look_up = [&] {
    for (std::size_t m = 0; m < models.size(); ++m) {
      numbers_[m].clear();
      if (chain.ground_from_model[m])
        for (const NamedPoint& point : models[m].points) numbers_[m].push_back(number(point.name));
    }
  };
  look_up();
  if (names_.empty()) return;
  const std::vector<int> order =
      bundle::elimination_order(neighbours(numbers_, names_.size()), positions, kPointsOfTile);
  std::vector<std::string> names(names_.size());
  for (auto& [name, number] : number_of_) {
    number = order[static_cast<std::size_t>(number)];
    names[static_cast<std::size_t>(number)] = name;
  }
  names_ = std::move(names);
  look_up();
  find_pattern();
}

int SharedPoints::number(const std::string& name) const {
  const auto found = number_of_.find(name);
  return found == number_of_.end() ? -1 : found->second;
}

std::vector<bool> SharedPoints::are_shared(std::size_t model) const {
  std::vector<bool> shared;
  for (const int number : numbers_[model]) shared.push_back(number >= 0);
  return shared;
}

void SharedPoints::find_pattern() {
  pattern_.resize((names_.size() + kPointsOfTile - 1) / kPointsOfTile);
  for (const std::vector<int>& model : numbers_)
    for (const int one : model)
      for (const int other : model)
        if (one > other && other >= 0)
          pattern_[static_cast<std::size_t>(one / kPointsOfTile)].push_back(other / kPointsOfTile);
  for (auto& columns : pattern_) {
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  }
}

}  // namespace collinea
