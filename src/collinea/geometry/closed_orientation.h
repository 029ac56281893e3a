// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "collinea/geometry/absolute_orientation.h"

namespace collinea {

/// By which closed form a similarity is found, all points of equal weight.
enum class ClosedForm : std::uint8_t {
  kUmeyama,     ///< align()
  kQuaternion,  ///< align_by_quaternion()
  kRodrigues,   ///< align_by_rodrigues()
};

/// An absolute orientation in closed form with what the errors of its points make of it, to first order. Each form is a
/// function of the points; with e = X - T - m R u its parameters change by H e, and with W = C_X + m^2 R C_u R'
///
///     covariance    H W H'                             of the seven parameters, as in AbsoluteOrientation
///     misfits       W - A H W - (A H W)' + A H W H' A'  their covariance; w is a misfit over its standard deviation
///     redundancy    1 - (A H)_ii                        their sum is 3n - 7
///     sigma0^2      e' (W^-1 - W^-1 A (A' W^-1 A)^-1 A' W^-1) e / (3n - 7)
///
/// sigma0 is that of the measurements: what a least squares adjustment of the misfits still takes up is not in it, so
/// that sigma0^2 (3n - 7) is chi-squared whatever the form loses by its equal weights. Nothing more is neglected than
/// squares of errors over distances between points; with residuals much larger than their sigmas (a gross error) the
/// figures are too small. `model_covariance` as in AbsoluteOptions. All points must be full. Nothing with fewer than
/// three, on a line, or when W is not positive definite.
[[nodiscard]] std::optional<AbsoluteOrientation> closed_orientation(std::span<const AbsoluteControl> pairs,
                                                                    ClosedForm form,
                                                                    const Eigen::MatrixXd* model_covariance = nullptr);

}  // namespace collinea
