// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/block/gauge.h"
#include "collinea/orient/given.h"
#include "collinea/orient/internal/reconstruction.h"
#include "collinea/orient/internal/remeasure.h"
#include "collinea/quality/examine.h"
#include "collinea/quality/variance_components.h"

namespace collinea {

/// How cameras took part in an adjustment.
struct CalibrationUsed {
  /// The set of parameters (AdjustOptions::calibration); none when no camera was calibrated.
  Calibration parameters = Calibration::kNone;
  std::map<CameraId, std::vector<int>> free;  ///< of each camera that was calibrated, ascending: Camera::Param
};

/// An oriented block and how it came about.
struct Orientation {
  Block block;        ///< poses, cameras as adjusted, tie points, observations; control and positions that were used
  Adjusted adjusted;  ///< of `block`, coarsely: near enough for an adjustment with all that follows from it
  AdjustScope scope;  ///< of that
  AdjustOptions options;
  bool georeferenced = false;                     ///< false: gauge without position, see adjusted.datum
  bool metric = false;                            ///< lengths are in metres: georeferenced, or scaled by distances
  bool relative_heights = false;                  ///< georeferenced in plan, but nothing gave a height
  Gauge gauge;                                    ///< what fixes position, attitude and scale
  std::vector<std::vector<ImageId>> other_parts;  ///< images that hang together, but not with the block
  std::vector<ImageId> alone;                     ///< images that are in no part
  int gross_measurements = 0;                     ///< of tie points, left out before the final least squares
  std::vector<Finding> findings;                  ///< gross errors in control among them
  std::set<ControlId> excluded_control;           ///< control points that were found wrong and not used
  std::set<std::size_t> excluded_geodetic;        ///< the same of Block::geodetic
  std::vector<ImageId> excluded_positions;        ///< images whose positions would outweigh all others
  SigmaFactors sigma_factors = as_given();    ///< what the given sigmas were multiplied by: control's, by what it shows
  Eigen::Vector3d position_shift_m{0, 0, 0};  ///< by which positions were moved to where control puts the block
  InstrumentOptions instruments;              ///< those of the options that took part
  CalibrationUsed calibration;                ///< of the adjustment that gave the block
  bool holds_given_poses = false;             ///< poses are as another program gave them
  double gsd_m = 0;                           ///< median size of a pixel at the tie points [m, or units of the gauge]
};

/// Orients a block from verified pairs: growth image by image, or from all at once (options.mode); the largest of
/// several parts is kept; with options.remeasure its tie points are measured anew in `images`; then datum by
/// positions (GNSS) and control, or scale by distances where neither fixes it, examination of both, and an
/// adjustment with all observations, without covariances. Errors: no two images fit together; mode global without
/// positions; cancelled.
[[nodiscard]] Result<Orientation> orient(const Block& setup, std::span<const ImagePair> pairs,
                                         const KeypointSource& keypoints, const OrientOptions& options, const Run& run,
                                         const ImageSource& images = {});

/// Intersects the tie points of the pairs with the poses as they are given; images without a pose stay out. With
/// options.refine_orientation the block is then adjusted (and options.remeasure followed) as one that was grown here.
/// Without, poses stay as they are, up to one similarity that brings a model from an arbitrary frame to the map, by
/// positions or control; a model that agrees with these as it lies is left there, and control is then only compared.
/// Control that fixed the similarity counts as used. Errors: no pose, no tie point; cancelled.
[[nodiscard]] Result<Orientation> orient_as_given(const Block& setup, std::span<const ImagePair> pairs,
                                                  const KeypointSource& keypoints, const GivenOrientation& given,
                                                  const OrientOptions& options, const Run& run,
                                                  const ImageSource& images = {});

}  // namespace collinea
