// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/report/internal/coverage.h"
#include "collinea/report/statistics.h"

namespace collinea {

// Drawings of the report, each a complete <svg>. `unit` is what lengths are in: "m", or "units" of a free model.

/// Footprints, image positions, control with exaggerated differences, north arrow and scale, seen from above.
[[nodiscard]] std::string block_map(const ReportInput& input, const Coverage& coverage, const std::string& unit);
/// How many images see each point of the ground.
[[nodiscard]] std::string overlap_map(const Overlap& overlap, const std::string& unit);
/// Coordinates of residuals with the normal distribution of the same standard deviation.
[[nodiscard]] std::string residual_histogram(const ResidualStatistics& statistics);
/// Tie points by the number of images that see them.
[[nodiscard]] std::string rays_chart(const ResidualStatistics& statistics);
/// Radial distortion over the distance from the principal point, before (may be null) and after the adjustment.
[[nodiscard]] std::string distortion_chart(const Camera& adjusted, const Camera* first);
/// Mean residual vectors over the image, exaggerated.
[[nodiscard]] std::string residual_pattern(const ResidualGrid& grid, const Camera& camera);

/// An image to stand in the page.
struct Preview {
  std::string jpeg;
  int width = 0, height = 0;
  double low_m = 0, high_m = 0;  ///< heights of the ends of the colour scale; equal: not a height model
};
[[nodiscard]] Result<Preview> preview_of_heights(const std::filesystem::path& geotiff, int longest_side_px);
[[nodiscard]] Result<Preview> preview_of_image(const std::filesystem::path& geotiff, int longest_side_px);
/// The colour scale of preview_of_heights.
[[nodiscard]] std::string height_scale(const Preview& preview, const std::string& unit);

}  // namespace collinea
