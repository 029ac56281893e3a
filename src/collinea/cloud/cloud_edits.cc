// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/cloud_edits.h"

#include <algorithm>

namespace collinea {

CloudEdits::CloudEdits(std::vector<CloudRegion> regions) : regions_(std::move(regions)) {
  for (const CloudRegion& region : regions_) rings_.emplace_back(region.ring_m);
}

void CloudEdits::apply(std::vector<CloudPoint>& points) const {
  if (!regions_.empty()) std::erase_if(points, [&](CloudPoint& point) { return !keeps(point); });
}

bool CloudEdits::keeps(CloudPoint& point) const {
  for (std::size_t i = 0; i < regions_.size(); ++i) {
    const bool inside = is_in(i, point.position);
    if (regions_[i].action == CloudAction::kClassify) {
      if (inside) point.classification = regions_[i].classification;
    } else if (inside == (regions_[i].action == CloudAction::kCut)) {
      return false;
    }
  }
  return true;
}

std::optional<std::uint8_t> CloudEdits::class_at(const Eigen::Vector3d& position) const {
  for (std::size_t i = regions_.size(); i-- > 0;)
    if (regions_[i].action == CloudAction::kClassify && is_in(i, position)) return regions_[i].classification;
  return std::nullopt;
}

std::string text_of(std::span<const CloudRegion> regions) {
  std::string text;
  const auto add = [&](double value) { text.append(reinterpret_cast<const char*>(&value), sizeof value); };
  const auto add_end = [&](const std::optional<double>& end) {
    text += end ? '|' : '-';
    if (end) add(*end);
  };
  for (const CloudRegion& region : regions) {
    text += std::string(word_of(region.action)) + " " + std::to_string(region.classification) + " " +
            std::to_string(region.ring_m.size()) + ":";
    for (const Eigen::Vector2d& point : region.ring_m)
      for (const double along : point) add(along);
    add_end(region.low_m);
    add_end(region.high_m);
  }
  return text;
}

std::vector<CloudRegion> regions_of_surface(std::vector<CloudRegion> regions) {
  const auto classifies = [](const CloudRegion& region) { return region.action == CloudAction::kClassify; };
  const auto makes_noise = [&](const CloudRegion& region) {
    return classifies(region) && is_noise(region.classification);
  };
  if (std::ranges::none_of(regions, makes_noise)) std::erase_if(regions, classifies);
  return regions;
}

std::vector<CloudRegion> regions_of_classes(std::vector<CloudRegion> regions) {
  std::erase_if(regions, [](const CloudRegion& region) { return region.action != CloudAction::kClassify; });
  return regions;
}

}  // namespace collinea
