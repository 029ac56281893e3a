// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/feature/interest.h"

namespace collinea {

/// The covariance [px^2] of the top of the paraboloid through the responses of 3 x 3 pixels (SubPixel::kParaboloid), by
/// independent noise of the pixels, to first order. With b_k the change of the top d by the response R_k,
///     d = -H^-1 s,   b_k = -H^-1 (ds/dR_k + dH/dR_k d),   C = noise^2 sum over pixels p of g_p g_p',
///     g_p = sum_k b_k dR_k/dI_p
/// s and H being slope and second derivatives of the paraboloid. Of the operators on the structure tensor
/// dR_k/dI_p follows by way of the derivatives of the measure by the tensor and of the tensor by the gradients; blobs
/// are linear in the pixels. Noise must be below the gradients that make the point: beyond, errors are larger.
/// Between two pixels that are as high noise decides whose paraboloid is taken, and the two differ by some hundredths
/// of a pixel more than this says. Where the point lies beside the corner of the object (the operators' own bias) no
/// noise tells. Nothing: Moravec (a least sum has no derivative) and SIFT, windows that leave the image, no top within
/// a pixel.
[[nodiscard]] std::optional<Eigen::Matrix2d> paraboloid_covariance(const GreyImage& image, int column, int row,
                                                                   const InterestOptions& options, double noise_grey);

/// Gives the points that were located by a paraboloid their covariances, with the noise of the options or, where that
/// is not given, of the image; it is then found.noise_grey, too.
void add_paraboloid_covariances(const GreyImage& image, const InterestOptions& options, InterestPoints& found);

}  // namespace collinea
