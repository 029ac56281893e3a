// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/cloud/internal/cloud_point.h"
#include "collinea/geometry/polygon.h"

namespace collinea {

/// Classes of ASPRS that the program knows.
constexpr std::uint8_t kUnclassified = 1, kGroundClass = 2, kLowNoise = 7, kHighNoise = 18;
[[nodiscard]] constexpr bool is_noise(std::uint8_t classification) {
  return classification == kLowNoise || classification == kHighNoise;
}

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

/// A text that is equal only of equal regions; for fingerprints.
[[nodiscard]] std::string text_of(std::span<const CloudRegion> regions);

/// Those that change which points make a surface: where no region is noise, classes do not.
[[nodiscard]] std::vector<CloudRegion> regions_of_surface(std::vector<CloudRegion> regions);

/// Those that give classes.
[[nodiscard]] std::vector<CloudRegion> regions_of_classes(std::vector<CloudRegion> regions);

/// Edits of a cloud, one after the other: a point that one removes is gone for all behind it. The order of the points
/// and everything else of them stays. Cost: for each point the sides of the rings whose bounds hold it.
class CloudEdits {
 public:
  explicit CloudEdits(std::vector<CloudRegion> regions);
  [[nodiscard]] bool empty() const { return regions_.empty(); }
  void apply(std::vector<CloudPoint>& points) const;
  /// The class that people gave what is at a position of the map; nothing: none.
  [[nodiscard]] std::optional<std::uint8_t> class_at(const Eigen::Vector3d& position) const;

 private:
  [[nodiscard]] bool keeps(CloudPoint& point) const;
  [[nodiscard]] bool is_in(std::size_t region, const Eigen::Vector3d& position) const {
    return regions_[region].spans(position.z()) && rings_[region].contains(position.head<2>());
  }
  std::vector<CloudRegion> regions_;
  std::vector<BoundedRing> rings_;  // of the regions
};

}  // namespace collinea
