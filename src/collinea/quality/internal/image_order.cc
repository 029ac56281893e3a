// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/image_order.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

namespace collinea {

std::vector<ImageId> images_of_strip(const std::map<ImageId, double>& strip) {
  std::vector<std::pair<double, ImageId>> by_time;
  for (const auto& [image, time] : strip) by_time.emplace_back(time, image);
  std::ranges::sort(by_time);
  std::vector<ImageId> images;
  for (const auto& [time, image] : by_time) images.push_back(image);
  return images;
}

std::vector<ImageId> order_flown(const Block& block, std::span<const std::map<ImageId, double>> strips) {
  std::vector<ImageId> order;
  std::set<ImageId> taken;
  for (const auto& strip : strips)
    for (const ImageId image : images_of_strip(strip))
      if (taken.insert(image).second) order.push_back(image);
  if (!order.empty()) return order;
  std::vector<std::pair<std::string, ImageId>> by_time;
  for (const auto& [image, pose] : oriented_images(block)) by_time.emplace_back(block.images.at(image).taken, image);
  std::ranges::sort(by_time);
  for (const auto& [time, image] : by_time) order.push_back(image);
  return order;
}

}  // namespace collinea
