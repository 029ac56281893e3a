// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <map>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/synthetic/internal/scene.h"

namespace collinea {

/// What a camera does to the light before it is written down.
struct Optics {
  double blur_px = 0.6;      ///< standard deviation of the point spread function
  double noise_grey = 1.5;   ///< standard deviation, the same for the three channels of a pixel [grey levels]
  double vignetting = 0.25;  ///< share of the light lost in the corners
};

/// A world, the images taken of it and all that is exactly known of both.
struct Truth {
  Scene scene;
  LocalFrame frame;
  /// Cameras and poses are exact. Priors, control coordinates and control measurements carry the errors a field crew
  /// and a receiver would have made; tie points are absent.
  Block block;
  std::map<ControlId, Eigen::Vector3d> marks_in_world;  ///< exact centres of the survey marks [m]
  std::map<ImageId, double> exposure;                   ///< gain of each image; 1 = nominal
  std::map<ImageId, std::array<double, 3>> white = {};  ///< further gains of red, green, blue; none: 1
  Optics optics;
  double gsd_m = 0.05;
  double nominal_focal_px = 0;  ///< what the header of the images implies
  double lens_mm = 8.8;
  /// The part of the ground (x, y of the world) the products should cover; nothing when a map is no view of the scene.
  std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> mapped;
  std::uint64_t seed = 1;
};

/// Where an image shows a point of a surface: exactly projected; nothing when it lies outside the image, closer than
/// `margin_px` to its border, or hidden.
[[nodiscard]] std::optional<Eigen::Vector2d> seen_at(const Truth& truth, ImageId image,
                                                     const Eigen::Vector3d& point_in_world, double margin_px = 0);

/// The surface point shown at a pixel; nothing where the sky is.
[[nodiscard]] std::optional<Hit> shown_at(const Truth& truth, ImageId image, const Eigen::Vector2d& pixel);

/// What detection and matching would find in images that are never made.
struct ObservationOptions {
  int points_per_image = 200;
  double noise_px = 0.5;
  double found_share = 0.5;
  double matched_share = 0.8;
  double wrong_share = 0.04;
  std::uint64_t seed = 1;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = ObservationOptions;
    visit(Field{"points_per_image", &O::points_per_image, "1",
                "at least so many features in each image, where the scene allows", 8, 100000});
    visit(Field{"noise_px", &O::noise_px, "px", "standard deviation of each coordinate of a feature", 0.0, 100});
    visit(
        Field{"found_share", &O::found_share, "1", "chance that a point is found in an image that shows it", 0.01, 1});
    visit(Field{"matched_share", &O::matched_share, "1",
                "chance that a point found in two images is matched between them", 0.01, 1});
    visit(Field{"wrong_share", &O::wrong_share, "1",
                "share of matches that lead to another feature, close to the epipolar line", 0.0, 1});
  }
};

/// The block of the truth with tie points and observations, without images: surface points, found in two images or
/// more, at their exact positions; their image points exactly projected plus normal noise. Nothing of matching takes
/// part.
[[nodiscard]] Result<Block> observations_only(const Truth& truth, const ObservationOptions& options, const Run& run);

}  // namespace collinea
