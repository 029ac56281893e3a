// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

namespace collinea {

// How well three coordinates were surveyed: their standard deviations [m], infinite where one was not, and the
// correlations of the first with the second, the first with the third, the second with the third. Correlations count
// between axes whose standard deviations are finite and above 0.

/// The covariance [m^2]; rows and columns of axes that were not surveyed are 0.
[[nodiscard]] Eigen::Matrix3d survey_covariance(const Eigen::Vector3d& sigma_m, const Eigen::Vector3d& correlation);

/// The inverse of that on the axes with a finite standard deviation above 0, elsewhere 0. Nothing when the correlations
/// are those of no covariance: two axes are as good as one, or less.
[[nodiscard]] std::optional<Eigen::Matrix3d> survey_weight(const Eigen::Vector3d& sigma_m,
                                                           const Eigen::Vector3d& correlation);

/// The correlations of a covariance; 0 where a variance is not a positive number.
[[nodiscard]] Eigen::Vector3d correlation_of(const Eigen::Matrix3d& covariance_m2);

}  // namespace collinea
