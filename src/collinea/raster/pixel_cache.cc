// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/pixel_cache.h"

#include <string>

namespace collinea {

Result<std::shared_ptr<const ColourImage>> PixelCache::image_of(ImageId image, int shrink) {
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    auto& slot = entries_[{image, shrink}];
    if (!slot) slot = std::make_shared<Entry>();
    entry = slot;
    entry->last_use = ++uses_;
  }
  const std::lock_guard decoding(entry->decoding);
  if (entry->image) return entry->image;
  COLLINEA_TRY(ColourImage decoded, source_(image, shrink));
  if (decoded.empty() || decoded.channels != 3)
    return fail(Errc::kUnsupported, "image " + std::to_string(image.value) + " has no colours");
  const auto raster = std::make_shared<const ColourImage>(std::move(decoded));
  const std::lock_guard lock(mutex_);
  entry->image = raster;
  entry->bytes = raster->data.size();
  cached_bytes_ += entry->bytes, ++cached_;
  make_room();
  return raster;
}

void PixelCache::make_room() {
  while (cached_bytes_ > most_bytes_ || cached_ > most_images_) {
    auto oldest = entries_.end();
    for (auto it = entries_.begin(); it != entries_.end(); ++it) {
      if (it->second->bytes == 0 || it->second->last_use == uses_) continue;
      if (oldest == entries_.end() || it->second->last_use < oldest->second->last_use) oldest = it;
    }
    if (oldest == entries_.end()) return;
    cached_bytes_ -= oldest->second->bytes, --cached_;
    entries_.erase(oldest);
  }
}

}  // namespace collinea
