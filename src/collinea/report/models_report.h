// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/io/text_table.h"
#include "collinea/models/anblock.h"
#include "collinea/models/model_block.h"
#include "collinea/models/models_of_block.h"
#include "collinea/orient/bundle_of_models.h"

namespace collinea {

/// A block of independent models as it was joined, with what it was joined from.
struct ModelsReport {
  std::vector<StereoModel> models;
  std::vector<SurveyedPoint> control;
  std::string model_unit = "m";  ///< of the models' coordinates; empty: the base
  bool sigmas_known = true;
  std::optional<double> sigma_guessed = {};  ///< in that unit
  double false_alarm = 0.001;
  std::vector<FormedModel> pairs;       ///< where models were formed from images
  std::vector<std::string> pair_names;  ///< parallel
  JoinedBlock block;
  bool chain_only = false;  ///< `block` is concatenate_models()
  std::optional<Anblock> anblock;
  std::string anblock_failure;           ///< why there is none, where one was wanted
  std::optional<BundleOfModels> bundle;  ///< of the measurements that models were formed from, where it was wanted
  std::vector<Finding> findings;

  /// Of coordinates of the block: m, or the models' unit where there is no control.
  [[nodiscard]] std::string ground_unit() const { return block.chain.on_ground ? "m" : model_unit; }
};

/// For a terminal: counts, sigma0 and its test, accuracy, control, models, suspects, what is weak or was left out.
[[nodiscard]] std::string models_text(const ModelsReport& report);

/// point X Y Z sigmas correlations models, and of Anblock and the bundle where there is one; models minus bundle and
/// the ratio of their sigmas.
[[nodiscard]] TextTable joined_point_table(const ModelsReport& report);
/// model X Y Z omega phi kappa scale with sigmas.
[[nodiscard]] TextTable joined_model_table(const ModelsReport& report);
/// model point v r w of U, V, W.
[[nodiscard]] TextTable model_residual_table(const ModelsReport& report);
/// point role differences sigmas r w.
[[nodiscard]] TextTable joined_control_table(const ModelsReport& report);
/// The models as they were joined: model point U V W sigma_U sigma_V sigma_W; as `collinea models` reads them.
[[nodiscard]] TextTable formed_model_table(const ModelsReport& report);
/// Their covariances between points.
[[nodiscard]] TextTable formed_covariance_table(const ModelsReport& report);

}  // namespace collinea
