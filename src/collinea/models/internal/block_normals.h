// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/math/tile_cholesky.h"
#include "collinea/models/internal/local_normals.h"
#include "collinea/models/internal/shared_points.h"
#include "collinea/models/model_chain.h"

namespace collinea {

/// The normal equations of a block of models, reduced to the points that it shares, and where their solution has come.
class BlockNormals {
 public:
  BlockNormals(const std::vector<StereoModel>& models, const std::vector<SurveyedPoint>& control, ModelChain chain,
               const Run& run);

  /// Gauss-Newton from the chain on; answers the number of steps. Then the inverse of the normals is there.
  [[nodiscard]] Result<int> settle(int most_steps);

  [[nodiscard]] const ModelChain& chain() const { return chain_; }
  [[nodiscard]] const SharedPoints& shared() const { return shared_; }
  [[nodiscard]] const ModelState& state(std::size_t m) const { return states_[m]; }
  [[nodiscard]] const Eigen::Vector3d& position(const std::string& point) const { return position_.at(point); }
  [[nodiscard]] double squares() const { return squares_; }  ///< v' P v
  [[nodiscard]] bool is_in(std::size_t m) const { return chain_.ground_from_model[m].has_value(); }
  [[nodiscard]] bool is_held(std::size_t m) const { return !chain_.on_ground && m == chain_.reference; }
  /// Of control that takes part; -1: of other points.
  [[nodiscard]] int number_of(const SurveyedPoint& point) const {
    return point.is_check || !chain_.points.contains(point.name) ? -1 : shared_.number(point.name);
  }
  /// Linearised at the solution. Error: its covariance, or its points, do not determine a model.
  [[nodiscard]] Result<LocalNormals> local(std::size_t m) const;
  /// Covariance of the shared points of a model, in the order of its columns; after settle().
  [[nodiscard]] Eigen::MatrixXd covariance_of(std::size_t m);

 private:
  [[nodiscard]] std::vector<int> rows_of(std::size_t m) const;
  [[nodiscard]] Result<> build();
  void add(const LocalNormals& normals, const std::vector<int>& rows);
  void add_control();
  [[nodiscard]] Result<> factorise();
  [[nodiscard]] Result<> step_model(std::size_t m, const Eigen::VectorXd& x, double& taken);

  const std::vector<StereoModel>& models_;
  const std::vector<SurveyedPoint>& control_;
  const Run& run_;
  ModelChain chain_;
  SharedPoints shared_;
  std::vector<ModelState> states_;
  std::map<std::string, Eigen::Vector3d> position_;
  std::vector<bool> is_fixed_;  // of each row
  bundle::TileMatrix matrix_;
  bundle::TileCholesky factor_;
  Eigen::VectorXd right_;
  double squares_ = 0;
};

}  // namespace collinea
