// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/jobs/internal/pair_cloud.h"

namespace collinea {

/// The pair resampled so that homologous points lie in one row.
struct EpipolarImages {
  GreyImage left, right;
};

/// The images are let go as soon as they are resampled.
[[nodiscard]] EpipolarImages epipolar_images(PairImages images, const ModelOfPair& model, Interpolation resampling,
                                             const Run& run);

/// Finds the surface as the options ask and writes it as cloud.ply, as it comes: neither the points of a dense surface
/// nor the disparities of images larger than 20 million pixels are in memory together. Fills `levels` of the report.
[[nodiscard]] Result<PairCloudSummary> write_surface(
    EpipolarImages images, const PairFiles& pair, const ModelOfPair& model, const PairOrientationSigma& by_orientation,
    const PairChainOptions& options, const std::filesystem::path& folder, PairReport& report, const Run& run);

}  // namespace collinea
