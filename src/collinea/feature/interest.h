// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/feature/interest_options.h"
#include "collinea/feature/local_maxima.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// A point that stands out. The centre of the upper-left pixel is (0.5, 0.5).
struct InterestPoint {
  Eigen::Vector2d position_px;
  double strength = 0;                                 ///< the response of the operator
  double scale_px = 0;                                 ///< standard deviation of the window or blur
  std::optional<Eigen::Matrix2d> covariance_px2 = {};  ///< from the noise of the pixels; of the paraboloid see below
  double roundness = 0;                                ///< by least squares: 4 det / trace^2 of the gradients
  bool is_circle = false;                              ///< by least squares: centre of a blob or ring, not a corner
  std::optional<MapPixel> pixel = {};                  ///< whose paraboloid it is the top of: interest_covariance.h
};

/// The responses at all pixels (the "corner map"), for one core at some 100 megapixels a second (Harris, bench/). With
/// kSift those of the difference of Gaussians. Of the gradient no mask is normalised, so that values are those of the
/// literature (Karfis 2.2-2.3, Bolognesi 4.2): thresholds depend on the mask and on the range of grey.
[[nodiscard]] FloatImage interest_map(const GreyImage& image, const InterestOptions& options);

struct InterestPoints {
  std::vector<InterestPoint> points;  ///< the strongest beside what their regions ask for (evenness) first
  std::size_t maxima = 0;             ///< of the map above the threshold
  std::size_t isolated = 0;           ///< of these, rejected because a single pixel makes them
  std::size_t on_edges = 0;           ///< rejected: blobs ten times as long as wide
  std::size_t not_located = 0;        ///< rejected: least squares found nothing within the window
  double threshold = 0;               ///< that was applied
  double noise_grey = 0;              ///< with covariances: that was given or found
};

/// Points by threshold, non-maximum suppression (local_maxima.h), rejection of isolated pixels, location between the
/// pixels and choice. Fewer than a window's pixels across: none. Single-threaded, without chance.
[[nodiscard]] InterestPoints find_interest_points(const GreyImage& image, const InterestOptions& options);
/// The same on a map that interest_map() made of the image with these options.
[[nodiscard]] InterestPoints find_interest_points(const GreyImage& image, const FloatImage& map,
                                                  const InterestOptions& options);

/// The pixels that find_interest_points() takes its points from, with a threshold that is given: all local maxima that
/// no single pixel makes, strongest first. The image is gone through in strips, side by side: memory for the strips
/// alone, the same bits for any number of threads. (A plateau of one value that is higher than 24 rows may count more
/// than once.) Not for kSift.
[[nodiscard]] std::vector<MapPixel> interest_pixels(const GreyImage& image, const InterestOptions& options,
                                                    const Run& run);

/// The power of a response that grows as contrast does: responses of Harris grow with its fourth power, those of blobs
/// with itself, the others with its square.
[[nodiscard]] double contrast_power(InterestOperator method);

/// Whether the response at a pixel rests on one pixel: it falls below half when, of the 3 x 3 pixels around, the one
/// that differs most from the median of its neighbours takes their value.
[[nodiscard]] bool is_isolated(const GreyImage& image, int column, int row, const InterestOptions& options);

}  // namespace collinea
