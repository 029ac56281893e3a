// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/math/tile_cholesky.h"

namespace collinea {

/// What one model says of one ground coordinate: row x of its unknowns + constant, with a weight.
struct ModelEquation {
  int model = 0;
  Eigen::Vector4d row = Eigen::Vector4d::Zero();  ///< of which the first `unknowns` count
  double constant = 0, weight = 1;
};

/// One ground coordinate: equations of the models that show the point and what was surveyed.
struct CoordinateEquations {
  std::vector<ModelEquation> models;
  std::optional<double> surveyed;
  double surveyed_sigma = 0;  ///< 0: fixed
};

/// Normal equations of the models' unknowns alone, by Inghilleri's elimination of ground coordinates.
class PairEquations {
 public:
  /// `unknowns` a model, at most 4. Which models share points must not change.
  PairEquations(int unknowns, int models, const std::vector<CoordinateEquations>& pattern_of);

  /// Solves; answers the unknowns, or the model at which they turn out not to be determined.
  struct Solution {
    std::vector<Eigen::Vector4d> of_model;
    double squares = 0;
    int undetermined = -1;
  };
  [[nodiscard]] Solution solve(const std::vector<CoordinateEquations>& coordinates, const Run& run);
  /// After solve: makes the covariances below available.
  void invert(const Run& run) { factor_.invert(run); }
  [[nodiscard]] Eigen::Matrix4d covariance(int first, int second);  ///< of models that share a point

 private:
  void add(const ModelEquation* first, const ModelEquation* second, double difference, double weight);

  int unknowns_;
  std::vector<int> number_;  // of each model, in the order of elimination
  bundle::TileMatrix matrix_;
  bundle::TileCholesky factor_;
  Eigen::VectorXd right_;
};

}  // namespace collinea
