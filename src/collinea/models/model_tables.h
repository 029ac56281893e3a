// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "collinea/io/text_table.h"
#include "collinea/models/stereo_model.h"

namespace collinea {

/// Models as a table gives them.
struct GivenModels {
  std::vector<StereoModel> models;  ///< in the order in which they first appear
  std::string unit = "m";           ///< of the coordinates, in which they are kept
  bool sigmas_given = false;        ///< false: sigma is a guess, and known up to a factor at best
  double sigma = 0;                 ///< the one that was taken where none is given
};

/// A table `model point U V W [sigma_U sigma_V sigma_W | sigma]`, one model after another or mixed. Coordinates stay in
/// the unit of U (m where it has none). `sigma`: of coordinates that state none, in that unit; nothing: a
/// ten-thousandth of the model's extent (RMS distance from the centroid). Errors: columns, numbers; sigmas below 0;
/// sigmas in some rows and not in others.
[[nodiscard]] Result<GivenModels> models_of(const TextTable& table, std::optional<double> sigma);

/// Puts covariances between coordinates of a model into it: a table `model point other UU UV UW VU VV VW WU WV WW` in
/// squares of the models' unit, each pair of points once, a point with itself too. What is not there is 0; a model of
/// which nothing is there keeps its sigmas. Errors: names that the models do not have, a pair twice, no symmetry.
[[nodiscard]] Result<> add_covariances(GivenModels& models, const TextTable& table);

/// A table `point X Y Z [sigma_X sigma_Y sigma_Z | sigma] [role]`; coordinates in m. A coordinate that is missing ("-")
/// is not given, a sigma of 0 fixes it. role: control (also where missing) or check. `sigma_m`: where none is given.
[[nodiscard]] Result<std::vector<SurveyedPoint>> surveyed_points_of(const TextTable& table, double sigma_m);

}  // namespace collinea
