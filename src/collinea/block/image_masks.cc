// SPDX-License-Identifier: Apache-2.0
#include "collinea/block/image_masks.h"

#include <utility>

#include "collinea/geometry/polygon.h"

namespace collinea {

void MaskRings::add(std::vector<Eigen::Vector2d> ring_px) {
  if (ring_px.empty()) return;
  Ring ring{std::move(ring_px), {}, {}};
  ring.lowest = ring.highest = ring.points.front();
  for (const Eigen::Vector2d& point : ring.points) {
    ring.lowest = ring.lowest.cwiseMin(point);
    ring.highest = ring.highest.cwiseMax(point);
  }
  rings_.push_back(std::move(ring));
}

bool MaskRings::hides(const Eigen::Vector2d& pixel) const {
  for (const Ring& ring : rings_) {
    if ((pixel.array() < ring.lowest.array()).any() || (pixel.array() > ring.highest.array()).any()) continue;
    bool inside = false;
    for (std::size_t i = 0; i < ring.points.size(); ++i)
      if (const auto x = crossing(ring.points[i], ring.points[(i + 1) % ring.points.size()], pixel.y());
          x && *x <= pixel.x())
        inside = !inside;
    if (inside) return true;
  }
  return false;
}

std::string MaskRings::text() const {
  std::string text;
  for (const Ring& ring : rings_) {
    text += std::to_string(ring.points.size()) + ":";
    for (const Eigen::Vector2d& point : ring.points)
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
