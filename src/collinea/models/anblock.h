// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/geometry/similarity3.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

struct AnblockOptions {
  bool sigmas_known = true;  ///< false: all standard deviations are known up to sigma0, of plan and of height apart
  int most_cycles = 20;
  double settled = 1e-3;  ///< largest move of a point in the last cycle, in median standard deviations of a coordinate
};

/// One cycle of Anblock: plan, then height.
struct AnblockCycle {
  double plan_sigma0 = 0, height_sigma0 = 0;  ///< NaN without redundancy
  double largest_move = 0;                    ///< of a point, on the ground
};

struct AnblockModel {
  Similarity3 ground_from_model;
  /// As if plan and height had nothing to do with each other: standard deviations of the position of its centroid (X,
  /// Y, Z), of omega, phi, kappa [rad] and of the scale.
  Eigen::Matrix<double, 7, 1> sigma = Eigen::Matrix<double, 7, 1>::Zero();
};

struct AnblockPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< weighted mean of models and control
  Eigen::Vector3d sigma = Eigen::Vector3d::Zero();
};

struct Anblock {
  std::vector<std::optional<AnblockModel>> models;  ///< parallel to what was given
  std::map<std::string, AnblockPoint> points;
  std::vector<AnblockCycle> cycles;
  long plan_redundancy = 0, height_redundancy = 0;
};

/// Anblock (Mussio 4.2; van den Hout 1966): joins models that are nearly level by turns in plan and in height, each of
/// which is linear, from omega = phi = 0 on:
///
///     X = a u - b v + tx,   Y = b u + a v + ty                               a = cos K / lambda, b = sin K / lambda
///     Z = omega (b u + a v) + phi (-a u + b v) + tz + w sqrt(a^2 + b^2)
///
/// After each cycle the models are turned by the omega and phi that were found, which makes the w omega / lambda and
/// w phi / lambda of the text's plan equations zero and the end free of its small angles. No approximate values are
/// needed but level models: to some 20 degrees.
///
/// Coordinates of points are eliminated as Inghilleri did (Mussio 4.2.5): a point in models j and h equates F_j and
/// F_h. In more than two models each of the k(k - 1)/2 pairs has the weight p_j p_h / sum p, with which the elimination
/// is exact (the text's is for two); weighted control is one more such model without unknowns, fixed control equates
/// each model to it.
///
/// Points far above the others (projection centres: by more than half the model's extent) have no part in the plan of a
/// cycle, where a tilt would show a hundred times; all their three coordinates take part in its height,
/// dX = phi w / lambda and dY = -omega w / lambda (Ackermann 1973). With them it takes some ten cycles, without the
/// three or four of the text.
///
/// Weights: 1 / variance of each model coordinate, u and v alike; correlations are not used. The scale that brings
/// them to the ground is that of the last cycle.
///
/// `used`: models that take part. Errors: kIllPosed: plan or height is not determined (two plan points, three heights
/// that are not on a line), with the model where that shows; kNotConverged: models that are not level.
/// Cost: a sparse system of four, then of three unknowns a model, for each cycle.
[[nodiscard]] Result<Anblock> anblock(const std::vector<StereoModel>& models, const std::vector<bool>& used,
                                      const std::vector<SurveyedPoint>& control, const AnblockOptions& options,
                                      const Run& run);

/// A model turned to be level, by its approximate orientation: coordinates and covariances. Anblock begins with these
/// where models come from anywhere.
[[nodiscard]] StereoModel levelled(const StereoModel& model, const Eigen::Quaterniond& ground_from_model);

}  // namespace collinea
