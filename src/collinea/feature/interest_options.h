// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "collinea/base/options.h"

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

}  // namespace collinea
