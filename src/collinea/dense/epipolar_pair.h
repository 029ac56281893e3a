// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/dense/internal/disparity_map.h"
#include "collinea/dense/internal/fused_point.h"
#include "collinea/raster/interpolation.h"

namespace collinea {

/// Two cameras side by side that look the same way: what is in a row of one image is in the same row of the other.
/// The right one stands base_m to the right of the left one; a point at depth z has the disparity
///     d = left_cx - right_cx + f base_m / z.
struct EpipolarPair {
  Camera left, right;  ///< pinholes with the same focal length and the same cy
  Rigid3 left_from_world;
  double base_m = 1;
  /// What turns the cameras of the images into these.
  Eigen::Quaterniond left_from_image = Eigen::Quaterniond::Identity(),
                     right_from_image = Eigen::Quaterniond::Identity();

  [[nodiscard]] double disparity_at(double depth_m) const;
  [[nodiscard]] double depth_at(double disparity_px) const;
};

/// The pair that two oriented images are resampled to: looking at right angles to the base, midway between the two
/// optical axes; pixels in the middle as large as those of the images. Errors: the images were taken from the
/// same position, look along the line between them, or have no rows in common.
[[nodiscard]] Result<EpipolarPair> epipolar_pair(const Camera& left, const Rigid3& left_from_world, const Camera& right,
                                                 const Rigid3& right_from_world);

/// Images that are an epipolar pair already: the left camera is the world, the principal points are in the middle.
[[nodiscard]] EpipolarPair epipolar_pair(double focal_px, double base_m, int left_width_px, int right_width_px,
                                         int height_px);

/// Where the pixels of `camera`, which is turned by camera_from_image, lie in an image: exact on a lattice of 8 pixels
/// and linear between, error < 0.003 px. The cameras must outlive its making only.
class ResamplingLattice {
 public:
  ResamplingLattice(const Camera& camera_of_image, const Eigen::Quaterniond& camera_from_image, const Camera& camera,
                    const Run& run, const RayBend& bend = {});
  /// In samples of the image (the middle of the first pixel is 0); NaN where it has nothing.
  [[nodiscard]] Eigen::Vector2f sample_of(int column, int row) const {
    const std::size_t i = std::size_t(row / kStep_px) * columns_ + std::size_t(column / kStep_px);
    const float u = float(column % kStep_px) / kStep_px, v = float(row % kStep_px) / kStep_px;
    const Eigen::Vector2f above = nodes_[i] + u * (nodes_[i + 1] - nodes_[i]);
    const Eigen::Vector2f* const below_node = nodes_.data() + i + columns_;
    const Eigen::Vector2f below = below_node[0] + u * (below_node[1] - below_node[0]);
    return above + v * (below - above);
  }

 private:
  static constexpr int kStep_px = 8;
  std::size_t columns_;
  std::vector<Eigen::Vector2f> nodes_;
};

/// An image (1 or 3 channels) as `camera` sees it, which is turned by camera_from_image, without the bend of its rays.
/// 0 where the image has nothing, else 1 to 255.
[[nodiscard]] Raster<std::uint8_t> resampled(const Raster<std::uint8_t>& image, const Camera& camera_of_image,
                                             const Eigen::Quaterniond& camera_from_image, const Camera& camera,
                                             const Run& run, const RayBend& bend = {},
                                             Interpolation interpolation = Interpolation::kBicubic);

/// The disparities of points that both cameras see, but the grossest half per cent on either side, and more beyond: a
/// tenth of what is farthest and eight tenths of what is nearest (trees and masts seldom have tie points), or three
/// tenths of the range. Nothing when there are fewer than eight.
[[nodiscard]] std::optional<DisparityRange> range_of(const EpipolarPair& pair,
                                                     std::span<const Eigen::Vector3d> points_in_world);

/// What is measured, in the world: with colours of `colours` (as the left camera sees it; may be empty), normals from
/// the neighbours, sigma along the ray. Points in the order of the pixels.
[[nodiscard]] std::vector<FusedPoint> cloud_of(const EpipolarPair& pair, const DisparityMap& map,
                                               const ColourImage& colours);

}  // namespace collinea
