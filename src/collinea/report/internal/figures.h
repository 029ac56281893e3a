// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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
/// Values of one band in the colours of heights, without light: standard deviations.
[[nodiscard]] Result<Preview> preview_of_values(const std::filesystem::path& geotiff, int longest_side_px);
/// Of a photograph (JPEG, PNG, TIFF).
[[nodiscard]] Result<Preview> preview_of_file(const std::filesystem::path& file, int longest_side_px);
using MakePreview = Result<Preview> (*)(const std::filesystem::path&, int);
/// A preview is a help, not a figure: when it cannot be made there is a finding, and none where `file` is empty.
[[nodiscard]] std::optional<Preview> preview_or_finding(MakePreview make, const std::filesystem::path& file,
                                                        std::vector<Finding>& findings);
/// The colour scale of preview_of_heights and preview_of_values.
[[nodiscard]] std::string height_scale(const Preview& preview, const std::string& unit, int decimals = 1);

}  // namespace collinea
