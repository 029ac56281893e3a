// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/rejection.h"

namespace collinea {

/// The rejections with their gross errors by an adjustment without them: measured minus what it says, with the standard
/// deviation that this would have without a gross error,
///
///     sigma_g = sigma sqrt(s^2 + sigma0^2 q)
///
/// with s = sigma0 of image points, 1 of all others, whose sigmas stay as given, and the cofactor q of what the others
/// predict. q is that of the adjustment after which it went, which knew less than the last one: what went since has
/// spoilt the residuals, and hardly the geometry. What cannot be compared keeps what it had (see misclosure()).
///
/// Image points that went before the first adjustment (Rejected::round 0) have no test: w is the gross error in sigmas,
/// and q that of the intersection of the other rays of the point, all images being exact. Fixed coordinates have no
/// sigma of their own: theirs is that of what the others say.
///
/// `left`: with the adjusted values. `sigma0`: by which observations are tested.
[[nodiscard]] std::vector<Rejection> with_gross_errors(std::vector<Rejection> rejections, const Measurements& left,
                                                       const Adjusted& adjusted, double sigma0);

}  // namespace collinea
