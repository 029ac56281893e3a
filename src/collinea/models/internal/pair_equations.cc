// SPDX-License-Identifier: Apache-2.0
#include "collinea/models/internal/pair_equations.h"

#include <algorithm>

#include "collinea/math/ordering.h"

namespace collinea {
namespace {

using bundle::kTile;
using Eigen::Index;

constexpr double kLeastPivot = 1e-12;

std::vector<int> order_of(int unknowns, int models, const std::vector<CoordinateEquations>& coordinates) {
  bundle::Covisibility graph(static_cast<std::size_t>(models));
  for (const CoordinateEquations& one : coordinates)
    for (const ModelEquation& a : one.models)
      for (const ModelEquation& b : one.models)
        if (a.model != b.model) graph[static_cast<std::size_t>(a.model)].push_back(b.model);
  for (auto& others : graph) {
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
  }
  std::vector<Eigen::Vector3d> nowhere(static_cast<std::size_t>(models), Eigen::Vector3d::Zero());
  return bundle::elimination_order(graph, nowhere, kTile / unknowns);
}

bundle::TilePattern pattern_of(int unknowns, const std::vector<int>& number,
                               const std::vector<CoordinateEquations>& coordinates) {
  const int per_tile = kTile / unknowns;
  bundle::TilePattern pattern((number.size() * static_cast<std::size_t>(unknowns) + kTile - 1) / kTile);
  for (const CoordinateEquations& one : coordinates)
    for (const ModelEquation& a : one.models)
      for (const ModelEquation& b : one.models) {
        const int row = number[static_cast<std::size_t>(a.model)], column = number[static_cast<std::size_t>(b.model)];
        if (row > column) pattern[static_cast<std::size_t>(row / per_tile)].push_back(column / per_tile);
      }
  for (auto& columns : pattern) {
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
  }
  return pattern;
}

}  // namespace

PairEquations::PairEquations(int unknowns, int models, const std::vector<CoordinateEquations>& coordinates)
    : unknowns_(unknowns),
      number_(order_of(unknowns, models, coordinates)),
      matrix_(unknowns * models, collinea::pattern_of(unknowns, number_, coordinates)),
      factor_(unknowns * models, collinea::pattern_of(unknowns, number_, coordinates)) {}

// Equation first - second = difference; no second: a given value.
void PairEquations::add(const ModelEquation* first, const ModelEquation* second, double difference, double weight) {
  const ModelEquation* const both[2] = {first, second};
  const double sign[2] = {1, -1};
  for (int i = 0; i < 2; ++i) {
    if (both[i] == nullptr) continue;
    const int row = unknowns_ * number_[static_cast<std::size_t>(both[i]->model)];
    for (int a = 0; a < unknowns_; ++a) {
      right_[row + a] += sign[i] * weight * both[i]->row[a] * difference;
      for (int k = 0; k < 2; ++k) {
        if (both[k] == nullptr) continue;
        const int column = unknowns_ * number_[static_cast<std::size_t>(both[k]->model)];
        for (int b = 0; b < unknowns_; ++b)
          if (column + b <= row + a)
            matrix_.at(row + a, column + b) += sign[i] * sign[k] * weight * both[i]->row[a] * both[k]->row[b];
      }
    }
  }
}

PairEquations::Solution PairEquations::solve(const std::vector<CoordinateEquations>& coordinates, const Run& run) {
  matrix_.clear();
  right_.setZero(Index{factor_.tile_rows()} * kTile);
  double squares = 0;
  for (const CoordinateEquations& one : coordinates) {
    const bool fixed = one.surveyed && one.surveyed_sigma == 0;
    double sum = one.surveyed && !fixed ? 1 / (one.surveyed_sigma * one.surveyed_sigma) : 0;
    for (const ModelEquation& equation : one.models) sum += equation.weight;
    for (std::size_t i = 0; i < one.models.size(); ++i) {
      const ModelEquation& first = one.models[i];
      if (one.surveyed) {
        const double weight = fixed ? first.weight : first.weight / (one.surveyed_sigma * one.surveyed_sigma) / sum;
        const double difference = *one.surveyed - first.constant;
        add(&first, nullptr, difference, weight);
        squares += weight * difference * difference;
      }
      for (std::size_t k = i + 1; k < one.models.size() && !fixed; ++k) {
        const double weight = first.weight * one.models[k].weight / sum;
        const double difference = one.models[k].constant - first.constant;
        add(&first, &one.models[k], difference, weight);
        squares += weight * difference * difference;
      }
    }
  }
  Solution out;
  if (!factor_.factor(matrix_, run, kLeastPivot)) {
    const auto found = std::find(number_.begin(), number_.end(), std::max(factor_.failed_row(), 0) / unknowns_);
    out.undetermined = static_cast<int>(found - number_.begin());
    return out;
  }
  Eigen::VectorXd x = right_;
  factor_.solve(x.data());
  out.squares = std::max(0.0, squares - right_.dot(x));
  for (const int number : number_) {
    out.of_model.emplace_back(Eigen::Vector4d::Zero());
    out.of_model.back().head(unknowns_) = x.segment(Index{unknowns_} * number, unknowns_);
  }
  return out;
}

Eigen::Matrix4d PairEquations::covariance(int first, int second) {
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  for (int a = 0; a < unknowns_; ++a)
    for (int b = 0; b < unknowns_; ++b) {
      const int row = unknowns_ * number_[static_cast<std::size_t>(first)] + a;
      const int column = unknowns_ * number_[static_cast<std::size_t>(second)] + b;
      covariance(a, b) = factor_.at(std::max(row, column), std::min(row, column));
    }
  return covariance;
}

}  // namespace collinea
