// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/report/adjustment_report.h"
#include "collinea/report/internal/adjustment_products.h"

namespace collinea {

/// Writes into the folder: adjustment.html (for people), adjustment.json (the same figures), and the tables poses.csv,
/// cameras.csv, points.csv, control.csv, geodetic.csv, unknowns.csv (beside those of images, cameras and points),
/// images, points, control and cameras once more in products.json and but for the cameras in adjustment.gpkg,
/// observations.csv (control, positions and ground, each with its test), suspects.csv and, after snooping,
/// rejected.csv; tie_residuals.csv where these are wanted. Lengths in metres, angles in degrees, standard deviations
/// times sigma0. Errors: disk, a CRS that PROJ does not know.
[[nodiscard]] Result<> write_adjustment(const AdjustmentReport& report, const std::filesystem::path& folder,
                                        const Run& run);

[[nodiscard]] std::string adjustment_page(const AdjustmentReport& report, const AdjustmentProducts& products);
[[nodiscard]] std::string adjustment_json(const AdjustmentReport& report);

}  // namespace collinea
