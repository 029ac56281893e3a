// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/jobs/internal/absolute_options.h"
#include "collinea/jobs/internal/control_fit.h"
#include "collinea/jobs/internal/ground_table.h"

namespace collinea {

struct ModelTable {
  std::vector<std::string> names;
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Matrix3d> covariances;
  std::optional<Eigen::MatrixXd> full;  ///< of all
  bool states_sigmas = false;
};

/// What both tables have.
struct AbsoluteTables {
  ModelTable model;
  GroundTable ground;
  std::vector<std::size_t> common;  ///< indices of the model
  ControlFit fit;                   ///< of them
};

/// Both tables and the points that they have in common. Errors: files, columns, a check point that is not in both, no
/// common point.
[[nodiscard]] Result<AbsoluteTables> read_absolute_tables(const std::filesystem::path& model,
                                                          const std::filesystem::path& ground,
                                                          const OrientAbsoluteOptions& options);

}  // namespace collinea
