// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collinea/feature/hough.h"

namespace collinea {

/// The pieces of straight lines: where no edge point lies on a line for more than `gap_px` it is cut, and each piece of
/// `least_points` and more is adjusted by itself. What lies in one line of an image (the sills of a row of windows) is
/// rarely one edge of the object. In the order of the lines.
[[nodiscard]] std::vector<FoundLine> line_segments(const EdgePoints& edges, std::span<const FoundLine> lines,
                                                   double gap_px, int least_points);

/// Grey values beside a line, away from its blur.
struct SideGreys {
  double darker = 0, brighter = 0;  ///< on the side against the normal, and along it
};
/// Medians over the piece of the line between its end points, 2 to 4 px to either side. Nothing where most of a side
/// lies outside of the image.
[[nodiscard]] std::optional<SideGreys> side_greys(const FloatImage& image, const EdgeLine& line);

/// The standard deviation [px], across the line, of the foot of a point on it.
[[nodiscard]] double sigma_across(const EdgeLine& line, const Eigen::Vector2d& at);

}  // namespace collinea
