// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/cloud/internal/cloud_point.h"
#include "collinea/geometry/polygon.h"

namespace collinea {

/// What becomes of the points of a region.
enum class CloudAction { kClassify, kCut, kCrop };
inline constexpr Word<CloudAction> kCloudActionWords[] = {
    {CloudAction::kClassify, "classify", "points inside get a class"},
    {CloudAction::kCut, "cut", "points inside are removed"},
    {CloudAction::kCrop, "crop", "points outside are removed"}};
[[nodiscard]] constexpr std::span<const Word<CloudAction>> words(CloudAction) { return kCloudActionWords; }

/// A prism over a part of the map, and what becomes of its points. Inside is behind an odd number of sides, and from
/// the lowest to the highest height, both included.
struct CloudRegion {
  CloudAction action = CloudAction::kClassify;
  std::uint8_t classification = 0;      ///< ASPRS; of kClassify
  std::vector<Eigen::Vector2d> ring_m;  ///< closed by itself, in the map
  std::optional<double> low_m, high_m;  ///< nothing: without end

  [[nodiscard]] bool spans(double height_m) const {
    return !(low_m && height_m < *low_m) && !(high_m && height_m > *high_m);
  }
  [[nodiscard]] bool contains(const Eigen::Vector3d& position) const {
    return spans(position.z()) && is_inside(ring_m, position.head<2>());
  }
};

/// Edits of a cloud, one after the other: a point that one removes is gone for all behind it. The order of the points
/// and everything else of them stays. Cost: for each point the sides of the rings whose bounds hold it.
class CloudEdits {
 public:
  explicit CloudEdits(std::vector<CloudRegion> regions);
  [[nodiscard]] bool empty() const { return regions_.empty(); }
  void apply(std::vector<CloudPoint>& points) const;

 private:
  [[nodiscard]] bool keeps(CloudPoint& point) const;
  std::vector<CloudRegion> regions_;
  std::vector<BoundedRing> rings_;  // of the regions
};

}  // namespace collinea
