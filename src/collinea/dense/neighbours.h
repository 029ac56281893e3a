// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <vector>

#include "collinea/block/block.h"

namespace collinea {

/// Rays farther apart see leaves, grass and edges too differently to tell anything of each other [rad].
inline constexpr double kWidestAngle_rad = 0.5;

/// The tie points an image sees, with what matching wants to know of them.
struct SeenPoint {
  Eigen::Vector3d point_in_cam;  ///< z > 0
  PointId point;
};

/// Which images see which tie points; built once per block, read by every image. The block must outlive it, but not its
/// points and observations, which take several times the memory.
class TieView {
 public:
  explicit TieView(const Block& block);

  /// Of a block whose tie points and observations come one by one: first all points, then all observations, each in the
  /// order of their ids, then finish(). Observations of unknown points and of images without pose are passed over.
  static TieView without_ties(const Block& block);
  void add(PointId id, const Eigen::Vector3d& position_in_world);
  void add(const Observation& seen);
  void finish();

  /// Tie points in front of the image's camera, in the order of their ids.
  [[nodiscard]] std::vector<SeenPoint> seen_by(ImageId image) const;

  /// Up to `count` images to match `image` with, best first: they see the same tie points, from 6 to 25 degrees aside,
  /// cover all of the image, and lie on different sides of it. Fewer (or none) when the block has no more.
  [[nodiscard]] std::vector<ImageId> neighbours(ImageId image, int count) const;

  /// All images that share at least six tie points with `image` (fewer may be wrong ones), most shared first, at most
  /// `count`.
  [[nodiscard]] std::vector<ImageId> overlapping(ImageId image, int count) const;

 private:
  struct Nothing {};
  TieView(const Block& block, Nothing) : block_(block) {}
  [[nodiscard]] std::size_t point_of(std::uint32_t ray) const;

  const Block& block_;
  std::vector<PointId> points_;
  std::vector<Eigen::Vector3d> positions_;  ///< of the points, in the world
  std::vector<std::uint32_t> first_ray_;    ///< of each point; one more at the end
  std::vector<ImageId> image_of_ray_;
  std::vector<std::uint8_t> cell_of_ray_;                  ///< of its image, where the ray lies
  std::map<ImageId, std::vector<std::uint32_t>> rays_of_;  ///< ascending
};

}  // namespace collinea
