// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collinea/camera/film_prior.h"
#include "collinea/film/ideal_image.h"
#include "collinea/film/scan_orientation.h"

namespace collinea {

/// What is given of the local deformation of all scans of a camera; nothing: it is estimated.
struct GivenDeformation {
  std::optional<double> sigma_mm = {}, correlation_mm = {};
};

/// What the marks say of the local deformation of scans that are brought to one ideal image, one for each: its standard
/// deviation by the residuals of all of them together, its length a seventh of the width until an adjustment finds it.
/// The affine transformation of a scan takes its part of it; of another transformation, of fewer marks, nothing is
/// taken. Empty where it is given as 0, or the marks show none.
[[nodiscard]] std::vector<FilmPrior> scan_deformation(std::span<const ScanOrientation* const> scans,
                                                      const IdealImage& ideal, const GivenDeformation& given);

}  // namespace collinea
