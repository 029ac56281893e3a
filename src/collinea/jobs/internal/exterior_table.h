// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "collinea/base/result.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// A pose with its covariance: of [rotation about the axes of the world (rad), centre (m)]; zero: exact.
struct UncertainPose {
  Rigid3 cam_from_world;
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// The exterior orientations of a table: image, X, Y, Z, omega, phi, kappa, with sigma_ columns where known, and
/// correlation_X_Y to correlation_phi_kappa; nothing is known of correlations from image to image.
struct ExteriorTable {
  std::map<std::string, UncertainPose> images;
  bool has_sigmas = false;
  bool is_metric = true;  ///< the column X states its unit

  /// The first of these names that the table has, or has without the end of either name. Nothing: none.
  [[nodiscard]] const UncertainPose* find(std::span<const std::string> names) const;
};

/// Errors: the table, an image twice, correlations that no covariance has.
[[nodiscard]] Result<ExteriorTable> read_exterior_table(const std::filesystem::path& path);

}  // namespace collinea
