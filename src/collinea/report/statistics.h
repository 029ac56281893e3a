// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/report/internal/report_input.h"

namespace collinea {

/// Root mean squares by axis (east, north, up) and of the distance; nothing where nothing was measured.
struct AxisRms {
  std::array<std::optional<double>, 3> axis_m;
  std::optional<double> spatial_m;  ///< of points known on all three axes
  int points = 0;                   ///< known on at least one axis
};

/// Root mean square of these; NaN on an axis: not measured there.
[[nodiscard]] AxisRms rms_of(std::span<const Eigen::Vector3d> differences_m);
/// Root mean square over the points of one kind. An axis counts only where the point was surveyed (finite Block sigma).
[[nodiscard]] AxisRms control_rms(const ReportInput& input, bool used);
[[nodiscard]] AxisRms position_rms(const ReportInput& input);

/// Mean length of those that are known; 0 without any.
[[nodiscard]] double mean_length_px(std::span<const Eigen::Vector2d> residuals_px);

/// What one image contributed.
struct ImageResiduals {
  ImageId image;
  int observations = 0;
  double rms_px = 0;  ///< of the residual lengths
};

/// Mean residual vectors of one camera over a grid on its image: shows what the camera model does not.
struct ResidualGrid {
  CameraId camera;
  int columns = 0, rows = 0;
  std::vector<Eigen::Vector2d> mean_px;  ///< observed minus computed, row by row
  std::vector<int> count;
};

/// Residuals of all tie points: observed minus computed.
struct ResidualStatistics {
  std::size_t observations = 0;
  double mean_px = 0;  ///< mean length
  double rms_px = 0;   ///< of single coordinates
  double largest_px = 0;
  double bin_px = 0;                   ///< width of a bin of the histogram
  std::vector<std::size_t> histogram;  ///< of single coordinates, centred on 0; the outermost bins take all beyond
  std::vector<ImageResiduals> images;  ///< oriented images, by id
  std::vector<ResidualGrid> grids;     ///< cameras with oriented images
  std::vector<std::size_t> rays;       ///< tie points seen in i images; the last entry: in so many or more
};
[[nodiscard]] ResidualStatistics residual_statistics(const Block& block);

/// Root mean square of the image residuals of a control point at its estimated position [px]; NaN: unknown.
[[nodiscard]] double control_rms_px(const Block& block, const ControlDifference& control);

}  // namespace collinea
