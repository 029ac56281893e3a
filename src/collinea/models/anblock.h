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
  int most_cycles = 20;
  double settled = 1e-3;  ///< largest move of a point in a cycle, in standard deviations of unit weight
};

/// One cycle of Anblock: plan, then height.
struct AnblockCycle {
  double plan_rms = 0, height_rms = 0;  ///< weighted RMS of residuals, sigma0 of each
  double largest_move = 0;              ///< of a point of the block, on the ground
};

struct AnblockModel {
  double a = 1, b = 0, tx = 0, ty = 0;        ///< X = a u - b v + tx + w phi / lambda, Y = b u + a v + ty - ...
  double omega = 0, phi = 0, tz = 0;          ///< rad, rad, ground unit
  Eigen::Matrix4d plan_covariance = Eigen::Matrix4d::Zero();      ///< of a, b, tx, ty
  Eigen::Matrix3d height_covariance = Eigen::Matrix3d::Zero();    ///< of omega, phi, tz
  [[nodiscard]] Similarity3 ground_from_model() const;            ///< with the exact rotation
};

struct AnblockResult {
  std::vector<std::optional<AnblockModel>> models;  ///< parallel to what was given
  std::map<std::string, Eigen::Vector3d> points;    ///< weighted mean of the models that show them, and of control
  std::vector<AnblockCycle> cycles;
  long plan_redundancy = 0, height_redundancy = 0;
  double plan_sigma0 = 0, height_sigma0 = 0;  ///< NaN without redundancy
};

/// Anblock (Mussio 4.2; van den Hout 1966): joins models that are nearly level by turns in plan and in height, each of
/// which is linear, from omega = phi = 0 on:
///
///     X = a u - b v + tx + w phi / lambda,   Y = b u + a v + ty - w omega / lambda
///     Z = omega (u sin K + v cos K) / lambda + phi (-u cos K + v sin K) / lambda + tz + w / lambda
///
/// with a = cos K / lambda, b = sin K / lambda. No approximate values are needed but level models: to a few degrees.
/// Coordinates of points are eliminated as Inghilleri did: a point in models j and h equates F_j and F_h. In more than
/// two models each pair of the k(k - 1)/2 has the weight p_j p_h / sum p, with which the elimination is exact (the text's
/// is for two); control is one more such model without unknowns.
///
/// Weights: 1 / variance of each model coordinate; those of u and v are taken together, correlations are not used. The
/// models' scale, which brings them to the ground, is that of the last cycle.
///
/// `used`: models that take part. Errors: kIllPosed: plan or height are not determined (two plan points; three heights,
/// and in strips heights across them), with the model where that shows; kNotConverged: models that are not level.
/// Cost: a banded system of four, then of three unknowns a model; no covariances between models are kept.
[[nodiscard]] Result<AnblockResult> anblock(const std::vector<StereoModel>& models, const std::vector<bool>& used,
                                            const std::vector<SurveyedPoint>& control, const AnblockOptions& options,
                                            const Run& run);

/// The models turned so that they are level by an approximate orientation of each: what Anblock begins with where
/// models come from anywhere. Their coordinates and covariances turn together.
[[nodiscard]] StereoModel levelled(const StereoModel& model, const Eigen::Quaterniond& ground_from_model);

}  // namespace collinea
