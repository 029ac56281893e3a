// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/geodesy/local_frame.h"
#include "collinea/synthetic/scene.h"

namespace collinea {

/// What a camera does to the light before it is written down.
struct Optics {
  double blur_px = 0.6;      ///< standard deviation of the point spread function
  double noise_grey = 1.5;   ///< standard deviation, the same for the three channels of a pixel [grey levels]
  double vignetting = 0.25;  ///< share of the light lost in the corners
};

/// A world, the photographs taken of it and all that is exactly known of both.
struct Truth {
  Scene scene;
  LocalFrame frame;
  /// Cameras and poses are exact. Priors, control coordinates and control measurements carry the errors a field crew
  /// and a receiver would have made; tie points are absent.
  Block block;
  std::map<ControlId, Eigen::Vector3d> marks_in_world;  ///< exact centres of the survey marks [m]
  std::map<ImageId, double> exposure;                   ///< gain of each image; 1 = nominal
  Optics optics;
  double gsd_m = 0.05;
  double nominal_focal_px = 0;  ///< what the header of the photographs implies
  double lens_mm = 8.8;
  /// The part of the ground (x, y of the world) the products should cover; nothing when a map is no view of the scene.
  std::optional<std::pair<Eigen::Vector2d, Eigen::Vector2d>> mapped;
  std::uint64_t seed = 1;
};

/// Where an image shows a point of a surface: exactly projected; nothing when it lies outside the picture, closer than
/// `margin_px` to its border, or hidden.
[[nodiscard]] std::optional<Eigen::Vector2d> seen_at(const Truth& truth, ImageId image,
                                                     const Eigen::Vector3d& point_in_world, double margin_px = 0);

/// The surface point shown at a pixel; nothing where the sky is.
[[nodiscard]] std::optional<Hit> shown_at(const Truth& truth, ImageId image, const Eigen::Vector2d& pixel);

struct ObservationOptions {
  int points_per_image = 300;  ///< at least so many observations in each image, where the scene allows
  double noise_px = 0.3;       ///< standard deviation of each image coordinate
  std::uint64_t seed = 1;
};

/// The block of the truth with tie points and observations, without pictures: surface points, visible in two images or
/// more, at their exact places; their image points exactly projected plus normal noise.
[[nodiscard]] Result<Block> observations_only(const Truth& truth, const ObservationOptions& options, const Run& run);

}  // namespace collinea
