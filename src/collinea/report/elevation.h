// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string>

#include "collinea/base/result.h"
#include "collinea/store/step_records.h"

namespace collinea {

/// A sheet of paper as a front view is drawn on it.
struct ElevationSheet {
  double scale = 0;                    ///< 50 for 1:50
  double width_mm = 0, height_mm = 0;  ///< of the paper
  std::string paper;                   ///< "A3"; empty: larger than A0

  /// PDF has no larger pages than 14,400 points.
  [[nodiscard]] bool fits_in_a_pdf() const { return std::max(width_mm, height_mm) <= 14400 * 25.4 / 72; }
};

/// The sheet for a drawing of so many metres. `scale`: nothing for the largest of the usual ones (1:1, 1:2, 1:5, 1:10,
/// 1:20, 1:25, 1:50, 1:100, 1:200, ...) that fits on A3; with it the smallest of A4 to A0, upright or across.
[[nodiscard]] ElevationSheet elevation_sheet(double width_m, double height_m, std::optional<double> scale);

/// Writes the front view of a plane as PDF: its orthophoto at scale, a grid with coordinates of the frame [m], a scale
/// bar, and what it is and how good: sizes, cells, standard deviations. `project`: its name. Returns the scale. The
/// same input gives the same bytes. Errors: the orthophoto cannot be read, disk.
[[nodiscard]] Result<double> write_elevation(const FrameRecord& frame, const std::filesystem::path& ortho,
                                             const std::string& project, bool is_metric, std::optional<double> scale,
                                             const std::filesystem::path& pdf);

}  // namespace collinea
