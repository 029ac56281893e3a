// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/image_masks.h"

#include <algorithm>
#include <utility>

namespace collinea {

void MaskRings::add(std::vector<Eigen::Vector2d> ring_px) { rings_.emplace_back(std::move(ring_px)); }

bool MaskRings::hides(const Eigen::Vector2d& pixel) const {
  return std::ranges::any_of(rings_, [&](const BoundedRing& ring) { return ring.contains(pixel); });
}

std::string MaskRings::text() const {
  std::string text;
  for (const BoundedRing& ring : rings_) {
    text += std::to_string(ring.points().size()) + ":";
    for (const Eigen::Vector2d& point : ring.points())
      text.append(reinterpret_cast<const char*>(point.data()), sizeof(double) * 2);
  }
  return text;
}

void ImageMasks::add(std::optional<ImageId> image, const std::vector<Eigen::Vector2d>& ring_px) {
  if (!image) {
    of_all_.add(ring_px);
    for (auto& [id, rings] : of_image_) rings.add(ring_px);
    return;
  }
  of_image_.try_emplace(*image, of_all_).first->second.add(ring_px);
}

const MaskRings* ImageMasks::of(ImageId image) const {
  if (const auto found = of_image_.find(image); found != of_image_.end()) return &found->second;
  return of_all_.empty() ? nullptr : &of_all_;
}

std::string ImageMasks::text() const {
  std::string text = of_all_.text();
  for (const auto& [id, rings] : of_image_) text += "image " + std::to_string(id.value) + " " + rings.text();
  return text;
}

}  // namespace collinea
