// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/cloud_edits.h"

namespace collinea {

CloudEdits::CloudEdits(std::vector<CloudRegion> regions) : regions_(std::move(regions)) {
  for (const CloudRegion& region : regions_) rings_.emplace_back(region.ring_m);
}

void CloudEdits::apply(std::vector<CloudPoint>& points) const {
  if (!regions_.empty()) std::erase_if(points, [&](CloudPoint& point) { return !keeps(point); });
}

bool CloudEdits::keeps(CloudPoint& point) const {
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    const bool inside = regions_[i].spans(point.position.z()) && rings_[i].contains(point.position.head<2>());
    if (regions_[i].action == CloudAction::kClassify) {
      if (inside) point.classification = regions_[i].classification;
    } else if (inside == (regions_[i].action == CloudAction::kCut)) {
      return false;
    }
  }
  return true;
}

}  // namespace collinea
