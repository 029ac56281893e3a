// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/models/model_chain.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

struct JoinOptions {
  bool sigmas_known =
      true;  ///< false: covariances of models and control are known up to a common factor, sigma0 squared
  double false_alarm = 0.001;
  int most_steps = 30;
};

/// A coordinate of a model or of control with what the others say of it.
struct CoordinateTest {
  double residual = 0;    ///< observed minus adjusted, in its own unit
  double redundancy = 0;  ///< 0 (nothing checks it) to 1
  double w = 0;  ///< Baarda's test, by sigma0 where sigmas are not known (Pope's tau); 0 where the redundancy is
};

/// Parameters of a model's absolute orientation, for people: the position of its origin on the ground, the angles of
/// ground = scale Rx(omega) Ry(phi) Rz(kappa) model + origin, and the scale; with their covariance in that order
/// [ground unit, rad, 1].
struct JoinedModel {
  Similarity3 ground_from_model;
  double omega_rad = 0, phi_rad = 0, kappa_rad = 0;
  Eigen::Matrix<double, 7, 7> covariance = Eigen::Matrix<double, 7, 7>::Zero();
  std::vector<std::array<CoordinateTest, 3>> tests;  ///< parallel to StereoModel::points
  double redundancy = 0;                             ///< sum of its coordinates' numbers
  double squares = 0;                                ///< v' P v of its coordinates
};

struct JoinedPoint {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  int models = 0;  ///< that show it
};

/// A surveyed point after the adjustment: `tests` of what takes part, `difference` of all axes that are given.
struct JoinedControl {
  std::size_t index = 0;                                 ///< in the list that was given
  bool seen = false;                                     ///< in a model that takes part
  Eigen::Vector3d difference = Eigen::Vector3d::Zero();  ///< given minus adjusted; NaN where not given
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();       ///< of the difference of a check point; NaN elsewhere
  std::array<CoordinateTest, 3> tests;
};

/// A block of models after its adjustment.
struct JoinedBlock {
  ModelChain chain;                                ///< from which it began, with what was left out
  std::vector<std::optional<JoinedModel>> models;  ///< parallel to what was given; nothing: left out
  std::vector<JoinedPoint> points;                 ///< by name
  std::vector<JoinedControl> control;              ///< parallel to what was given
  long unknowns = 0, observations = 0;
  [[nodiscard]] long redundancy() const { return observations - unknowns; }
  double squares = 0;  ///< v' P v
  double sigma0 = 0;   ///< NaN without redundancy
  /// Factor of all covariances above, already applied: 1 where sigmas are known.
  double variance_factor = 1;
  double chance = 1;  ///< that v' P v is as large or larger, if the sigmas are right
  double limit = 0;   ///< of |w|
  int steps = 0;
};

/// Joins independent models to a block, spatially at once, by rigorous least squares: seven parameters a model, three
/// coordinates a point, the covariance of each model as it was given (also between its points).
///
/// Model (Mussio 2.4, 4.3.7):   u_ij + v_ij = s_j Q_j (X_i - t_j),   X_i + v_i = X_i given for control,
/// with the covariance of u of a model as a whole. What belongs to one model alone (its seven parameters, and points
/// that no other model and no control shows) is eliminated model by model; the reduced normal equations of the other
/// points are sparse, are ordered by nested dissection and factored in tiles. Covariances come from their selected
/// inverse. The covariance of a model may be singular by what its frame was chosen for (projection centre in the
/// origin, unit base): the seven free parameters make any such choice harmless.
///
/// Approximate values are those of the chain (chain_models()) or, where models agree better after it, of Anblock.
/// Without control the frame is that of the model `chain.reference`, whose seven parameters are held.
///
/// What is correlated between models (an image that serves two of them) is not in the model: see
/// docs/theory/independent-models.md for what that costs.
///
/// Errors: those of chain_models(); kIllPosed: a covariance that is none, or an unknown that is not determined, by
/// name; kNotConverged; kCancelled. Cost: linear in the models where each has some dozens of points; about a minute for
/// thousand models with twenty.
[[nodiscard]] Result<JoinedBlock> join_models(const std::vector<StereoModel>& models,
                                              const std::vector<SurveyedPoint>& control, const JoinOptions& options,
                                              const Run& run);

}  // namespace collinea
