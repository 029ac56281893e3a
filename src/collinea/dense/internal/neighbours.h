// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/base/record_spool.h"
#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// Rays farther apart see leaves, grass and edges too differently to tell anything of each other [rad].
inline constexpr double kWidestAngle_rad = 0.5;

/// Which images see which tie points, image by image: what an image asks for is with its own rays, so that a block of
/// any size can leave them on disk. The block must outlive it, but not its points and observations. What is asked may
/// be asked from several threads at once, but not while points are added. Errors: the disk was full, or is broken.
class TieView {
 public:
  /// The view of a whole block, in memory.
  explicit TieView(const Block& block);

  /// The view of a block whose tie points come one by one. They lie on disk, in a file without a name beside `file`; in
  /// memory are kBuffered bytes of them and a few for each image, however many there are.
  static Result<TieView> on_disk(const Block& block, const std::filesystem::path& file);
  static constexpr std::size_t kBuffered = std::size_t{1} << 20;

  /// The next point, in the order of ids, and its observations. Those by images without pose are passed over.
  void add(const Eigen::Vector3d& position_in_world, std::span<const Observation> observations);

  /// Tie points in front of the image's camera, in its frame (z > 0), in the order of their ids.
  [[nodiscard]] Result<std::vector<Eigen::Vector3d>> seen_by(ImageId image) const;

  /// Up to `count` images to match `image` with, best first: they see the same tie points, from 6 to 25 degrees aside,
  /// cover all of the image, and lie on different sides of it. Fewer (or none) when the block has no more.
  [[nodiscard]] Result<std::vector<ImageId>> neighbours(ImageId image, int count) const;

  /// All images that share at least six tie points with `image` (fewer may be wrong ones), most shared first, at most
  /// `count`.
  [[nodiscard]] Result<std::vector<ImageId>> overlapping(ImageId image, int count) const;

  /// What it holds in memory, but for the constant part.
  [[nodiscard]] std::size_t bytes_in_memory() const;

 private:
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  struct Piece {  ///< of the rays of an image, on disk: the position of the piece before it, then the rays
    std::uint64_t at = kNone, bytes = 0;
  };
  struct Rays {  ///< of an image, in the order of points: first those of the pieces, then those in memory
    Piece last;
    std::string in_memory;
  };
  struct Ray;
  explicit TieView(const Block* block) : block_(block) {}
  void move_to_disk();
  [[nodiscard]] Result<std::string> rays_of(ImageId image) const;
  template <class Visit>
  [[nodiscard]] Result<> for_rays(ImageId image, Visit&& visit) const;

  const Block* block_;
  std::map<ImageId, Rays> rays_;
  std::size_t buffered_ = 0;
  std::optional<RecordSpool> spool_;
};

}  // namespace collinea
