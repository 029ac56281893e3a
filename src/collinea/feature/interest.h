// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/feature/local_maxima.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// What makes a pixel interesting. The map of an operator holds its response at every pixel: 0 where a window leaves
/// the image, and 0 in place of negative responses of Harris' measure (edges).
enum class InterestOperator : std::uint8_t {
  kMoravec,
  kHarris,
  kNoble,
  kKovesi,
  kShiTomasi,
  kFoerstner,
  kLog,
  kDog,
  kSift
};
inline constexpr Word<InterestOperator> kInterestOperatorWords[] = {
    {InterestOperator::kMoravec, "moravec", "smallest sum of squared differences over eight shifts"},
    {InterestOperator::kHarris, "harris", "det - k trace^2 of the structure tensor"},
    {InterestOperator::kNoble, "noble", "det / trace"},
    {InterestOperator::kKovesi, "kovesi", "det / trace of Prewitt gradients, as in Kovesi's program"},
    {InterestOperator::kShiTomasi, "shi-tomasi", "smaller eigenvalue"},
    {InterestOperator::kFoerstner, "foerstner", "det / trace where round enough, located by least squares"},
    {InterestOperator::kLog, "log", "blobs: Laplacian of Gaussian"},
    {InterestOperator::kDog, "dog", "blobs: difference of Gaussians"},
    {InterestOperator::kSift, "sift", "blobs of all scales"}};
[[nodiscard]] constexpr std::span<const Word<InterestOperator>> words(InterestOperator) {
  return kInterestOperatorWords;
}

/// How a point is located between the pixels.
enum class SubPixel : std::uint8_t { kNone, kParaboloid, kFoerstner, kFollowing };
inline constexpr Word<SubPixel> kSubPixelWords[] = {
    {SubPixel::kNone, "none", "the pixel of the maximum"},
    {SubPixel::kParaboloid, "paraboloid", "top of the surface of second degree through 3 x 3 responses"},
    {SubPixel::kFoerstner, "foerstner", "least squares over the gradients around it, with covariance"},
    {SubPixel::kFollowing, "following", "the same in a window that follows the point: for targets and crossings"}};
[[nodiscard]] constexpr std::span<const Word<SubPixel>> words(SubPixel) { return kSubPixelWords; }

struct InterestOptions {
  InterestOperator method = InterestOperator::kHarris;
  double sigma_px = 1.5;
  std::optional<int> window_radius_px;
  double harris_k = 0.04;
  double least_roundness = 0.3;
  std::optional<double> threshold;
  double relative_threshold = 0.01;
  int radius_px = 4;
  bool keep_isolated = false;
  std::optional<SubPixel> sub_pixel;
  std::optional<double> noise_grey;
  int max_points = 5000;
  double evenness = 0.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = InterestOptions;
    visit(Field{"operator", &O::method, "", "what makes a point interesting"});
    visit(Field{"sigma_px", &O::sigma_px, "px",
                "standard deviation of the Gaussian window, or of the blur of log and dog", 0.3, 30});
    visit(Field{"window_radius_px", &O::window_radius_px, "px",
                "of the window: 2 radius + 1 pixels across; nothing: 1 with moravec, three sigmas otherwise", 1, 100});
    visit(Field{"harris_k", &O::harris_k, "1", "k of Harris' measure: 0.04 to 0.06 are usual", 0, 0.24});
    visit(Field{"least_roundness", &O::least_roundness, "1",
                "of foerstner: least 4 det / trace^2; 1 = alike in all directions, 0 = an edge", 0.0, 1.0});
    visit(Field{"threshold", &O::threshold, "",
                "least response, in the unit of the operator; nothing: as a part of the strongest", 0});
    visit(Field{"relative_threshold", &O::relative_threshold, "1",
                "least response as a part of the strongest, where no threshold is given", 0.0, 1.0});
    visit(Field{"radius_px", &O::radius_px, "px", "a point is the strongest within so many columns and rows", 1, 1000});
    visit(Field{"keep_isolated", &O::keep_isolated, "", "keep points that a single pixel makes"});
    visit(Field{"sub_pixel", &O::sub_pixel, "", "how points are located between the pixels"}.or_auto(
        "foerstner with that operator, paraboloid with the others"));
    visit(Field{"noise_grey", &O::noise_grey, "grey",
                "standard deviation of the noise of a pixel, for covariances; nothing: from the image", 0, 255});
    visit(Field{"max_points", &O::max_points, "1", "most points kept", 1, 1e7});
    visit(Field{"evenness", &O::evenness, "1",
                "how evenly points are spread: 0 = the strongest, wherever they are, 1 = as many in every region", 0.0,
                1.0});
  }
};

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
