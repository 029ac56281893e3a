// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/cloud_edits.h"

#include <limits>

#include "collinea/geometry/polygon.h"

namespace collinea {

bool CloudRegion::contains(const Eigen::Vector3d& position) const {
  if ((low_m && position.z() < *low_m) || (high_m && position.z() > *high_m)) return false;
  bool inside = false;
  for (std::size_t i = 0; i < ring_m.size(); ++i)
    if (const auto x = crossing(ring_m[i], ring_m[(i + 1) % ring_m.size()], position.y()); x && *x <= position.x())
      inside = !inside;
  return inside;
}

CloudEdits::CloudEdits(std::vector<CloudRegion> regions) : regions_(std::move(regions)) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const CloudRegion& region : regions_) {
    Bounds bounds{Eigen::Vector2d::Constant(kInfinity), Eigen::Vector2d::Constant(-kInfinity)};
    for (const Eigen::Vector2d& point : region.ring_m) {
      bounds.lowest = bounds.lowest.cwiseMin(point);
      bounds.highest = bounds.highest.cwiseMax(point);
    }
    bounds_.push_back(bounds);
  }
}

void CloudEdits::apply(std::vector<CloudPoint>& points) const {
  if (!regions_.empty()) std::erase_if(points, [&](CloudPoint& point) { return !keeps(point); });
}

bool CloudEdits::keeps(CloudPoint& point) const {
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    const auto plan = point.position.head<2>().array();
    const bool is_near = (plan >= bounds_[i].lowest.array()).all() && (plan <= bounds_[i].highest.array()).all();
    const bool inside = is_near && regions_[i].contains(point.position);
    if (regions_[i].action == CloudAction::kClassify) {
      if (inside) point.classification = regions_[i].classification;
    } else if (inside == (regions_[i].action == CloudAction::kCut)) {
      return false;
    }
  }
  return true;
}

}  // namespace collinea
