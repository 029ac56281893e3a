// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "collinea/math/tile_cholesky.h"
#include "collinea/models/model_chain.h"

namespace collinea {

/// The unknowns that the reduced normal equations of a block are of: points in several of its models or in its control,
/// in the order of elimination, three rows each.
class SharedPoints {
 public:
  SharedPoints(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control,
               const ModelChain& chain);

  [[nodiscard]] int count() const { return static_cast<int>(names_.size()); }
  [[nodiscard]] const std::string& name(int number) const { return names_[static_cast<std::size_t>(number)]; }
  /// The number of a point; -1: it is not shared.
  [[nodiscard]] int number(const std::string& name) const;
  /// Of each point of a model.
  [[nodiscard]] const std::vector<int>& numbers(std::size_t model) const { return numbers_[model]; }
  [[nodiscard]] std::vector<bool> are_shared(std::size_t model) const;
  [[nodiscard]] const bundle::TilePattern& pattern() const { return pattern_; }

 private:
  void find_pattern();

  std::map<std::string, int> number_of_;
  std::vector<std::string> names_;
  std::vector<std::vector<int>> numbers_;  // of each model's points; empty: left out
  bundle::TilePattern pattern_;
};

}  // namespace collinea
