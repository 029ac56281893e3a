// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/raster/jpeg_reader.h"
#include "collinea/raster/raster.h"
#include "collinea/restitution/stereo_geometry.h"

namespace collinea {

struct GroundMatchOptions {
  int window_px = 21;
  int search_px = 12;
  double least_correlation = 0.7;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = GroundMatchOptions;
    visit(Field{"window_px", &O::window_px, "px", "side of the window that is matched, odd", 9, 61});
    visit(
        Field{"search_px", &O::search_px, "px", "so far to each side of the mark the parallax is looked for", 0, 100});
    visit(Field{"least_correlation", &O::least_correlation, "1", "of the windows of both photographs", 0, 1});
  }
};

/// The mark on the ground.
struct GroundMatch {
  StereoMark mark;      ///< x and y as asked for
  double sigma_px = 0;  ///< of the parallax, without the orientation
  double correlation = 0;
  Eigen::Vector3d position_in_world;
  std::array<Eigen::Vector2d, 2> pixels;  ///< where the photographs show it, left and right
  /// Of each of the two marks that stand for the parallax in an intersection: sigma_px / sqrt(2).
  [[nodiscard]] double mark_sigma_px() const;
};

/// Grey values of a window of a photograph.
using PhotoWindow = std::function<Result<FloatImage>(ImageId image, const PixelWindow& window)>;

/// Sets the parallax of a mark on the ground: what the left photograph shows at it is looked for along its row in the
/// right one, by least squares matching with a window that leans as the ground does (match_in_images() on the two
/// epipolar windows, bicubic), and back from the right one. The standard deviation holds the noise that the windows
/// show and kResampling_px, of the interpolation. Only windows of the photographs are read. Errors: kBadInput, the mark
/// or its window is not in both; kNotConverged, no or no sure match, and why; those of reading.
[[nodiscard]] Result<GroundMatch> match_ground(const Block& block, const StereoGeometry& model, const StereoMark& mark,
                                               const PhotoWindow& photo, const GroundMatchOptions& options);
inline constexpr double kResampling_px = 0.05;

}  // namespace collinea
