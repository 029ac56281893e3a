// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/words.h"
#include "collinea/camera/camera.h"
#include "collinea/geometry/rigid3.h"
#include "collinea/raster/raster.h"

// Least squares matching of one point in several oriented images at once, all rays meeting in the point (Gruen and
// Baltsavias 1988: geometrically constrained multiphoto matching). docs/theory/multi-image-matching.md.
namespace collinea {

/// An image with known interior and exterior orientation. Image and camera outlive it.
struct OrientedView {
  const GreyImage* image = nullptr;
  const Camera* camera = nullptr;  ///< of this image; distortion is followed exactly at the point
  Rigid3 cam_from_world;
};

struct MultiImageOptions {
  int window_px = 21;
  int refine_search_px = 3;
  double ray_sigma_px = 0;
  double least_correlation = 0.7;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = MultiImageOptions;
    visit(Field{"window_px", &O::window_px, "px", "side of the window of the reference image, odd", 9, 61});
    visit(Field{"refine_search_px", &O::refine_search_px, "px",
                "so far to each side of the start the point is looked for along its ray, by correlation in all images; "
                "0: the start is taken as it is",
                0, 200});
    visit(Field{"ray_sigma_px", &O::ray_sigma_px, "px",
                "by how much rays miss their point because of errors of the orientations; 0: they meet exactly", 0,
                10});
    visit(Field{"least_correlation", &O::least_correlation, "1",
                "of an image with the reference; an image with less is left out", 0, 1});
  }
};

enum class MultiImageOutcome {
  kFound,
  kOutside,       ///< the window does not lie in the reference image, or the ray misses the start
  kFewViews,      ///< no other image shows the window at a scale of 0.5 to 2 and is alike
  kNoTexture,     ///< nothing fixes the position along the ray: constant grey, edges along the epipolar lines
  kParallel,      ///< rays too parallel
  kNotConverged,  ///< or farther from the start than the search and half a window
};

inline constexpr Word<MultiImageOutcome> kMultiImageOutcomeWords[] = {
    {MultiImageOutcome::kFound, "found"},
    {MultiImageOutcome::kOutside, "outside", "the window does not lie in the reference image"},
    {MultiImageOutcome::kFewViews, "few views", "no other image shows the window and is alike"},
    {MultiImageOutcome::kNoTexture, "no texture", "nothing fixes the position along the ray"},
    {MultiImageOutcome::kParallel, "parallel", "the rays are too parallel"},
    {MultiImageOutcome::kNotConverged, "not converged", "the windows moved away from the start"}};
constexpr std::span<const Word<MultiImageOutcome>> words(MultiImageOutcome) { return kMultiImageOutcomeWords; }

/// The window in one image.
struct WindowInView {
  bool is_used = false;                 ///< the reference is not
  Eigen::Vector2d pixel;                ///< of the point
  Eigen::Matrix2d px_from_reference;    ///< affine map: an offset in the reference, seen here
  double gain = 1, offset_grey = 0;     ///< grey here = gain * grey of the reference + offset
  double correlation = 0;               ///< with the reference
  Eigen::Vector2d misclosure_px{0, 0};  ///< where the image alone would have the point, minus `pixel`
};

struct MultiImagePoint {
  MultiImageOutcome outcome = MultiImageOutcome::kOutside;
  Eigen::Vector3d point_in_world{0, 0, 0};
  /// Of the surface point that the pixel of the reference shows: nearly of rank 1, along its ray, where ray_sigma_px is
  /// 0. How well the pixel marks what the user means is not in it.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  std::vector<WindowInView> views;  ///< in the order given; of the reference pixel and correlation 1
  double noise_grey = 0;            ///< standard deviation of the noise of a pixel, as the differences show it
  /// Noise of means over 3 x 3 pixels against that of white noise: above 1 where neighbours err alike (JPEG, resampled
  /// or sharpened images, texture finer than a pixel); sigmas are multiplied by it.
  double slow_noise = 1;
  /// Whether all rays meet in one point: chi-squared with `redundancy` degrees of freedom, 2 k - 1 for k other images.
  double statistic = 0;
  int redundancy = 0;
  int iterations = 0;
};

/// The point that `reference_px` of views[reference] shows, from a start good to refine_search_px in the images.
/// Unknown are the point, and of each other image an affine map, gain and offset of its window. The grey values of all
/// images count with the noise that they have: white in the pixels of each image, of equal size, that of the reference
/// common to all differences (it does not average out over images).
[[nodiscard]] MultiImagePoint match_in_images(std::span<const OrientedView> views, std::size_t reference,
                                              const Eigen::Vector2d& reference_px,
                                              const Eigen::Vector3d& start_in_world, const MultiImageOptions& options);

}  // namespace collinea
