// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/orient/internal/reconstruction.h"
#include "collinea/raster/raster.h"

namespace collinea {

using ImageSource = std::function<Result<GreyImage>(ImageId)>;

/// Where an image shows a tie point, measured anew.
struct Remeasured {
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();  ///< by the noise of this image alone
  double reach_px = 0;                                       ///< half the side of the window
  /// Of a coordinate: both axes alike, and not less than what the iteration leaves.
  [[nodiscard]] double sigma_px() const { return std::sqrt(covariance_px2.trace() / 2 + std::pow(kLeastSigma_px, 2)); }
  static constexpr double kLeastSigma_px = 0.003;

  bool is_reference = false;  ///< the others are matched with it; it stays where it was
};

/// Measures the images of the tie points of an oriented block once more, by least squares matching: of each point, the
/// image seen from nearest the middle of its directions is the reference and keeps its position; the others are matched
/// with it. The window reaches four times the scale of the reference's feature, but eight pixels at least, to each
/// side. Poses and points predict how it is turned and stretched elsewhere, on a surface that faces the cameras.
///
/// The new positions, in the order of block.observations; nothing where there is none: no convergence (see
/// ReferenceWindow), farther from the old position than the feature's scale, at the border, image not readable, or an
/// image without a partner. Memory: the images in work, and pieces of images of at most 65536 observations at a
/// time. Every image is read once for each such lot of points that it shows. Errors: keypoints not readable,
/// cancelled.
[[nodiscard]] Result<std::vector<std::optional<Remeasured>>> remeasure(const Block& block,
                                                                       const KeypointSource& keypoints,
                                                                       const ImageSource& images, const Run& run);

/// Leaves positions to so many points that their windows share no pixels: errors of others would be alike, and the
/// adjustment takes them as independent. The smallest windows come first, of these those in most images; a point keeps
/// all of its positions or none.
void keep_apart(const Block& block, std::vector<std::optional<Remeasured>>& positions);

}  // namespace collinea
