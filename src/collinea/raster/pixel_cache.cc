// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/pixel_cache.h"

#include <string>

namespace collinea {

Result<std::shared_ptr<const ColourImage>> PixelCache::picture(ImageId image, int shrink) {
  std::shared_ptr<Entry> entry;
  {
    const std::lock_guard lock(mutex_);
    auto& slot = entries_[{image, shrink}];
    if (!slot) slot = std::make_shared<Entry>();
    entry = slot;
    entry->last_use = ++uses_;
  }
  const std::lock_guard decoding(entry->decoding);
  if (entry->picture) return entry->picture;
  COLLINEA_TRY(ColourImage decoded, source_(image, shrink));
  if (decoded.empty() || decoded.channels != 3)
    return fail(Errc::kUnsupported, "image " + std::to_string(image.value) + " has no colours");
  const auto picture = std::make_shared<const ColourImage>(std::move(decoded));
  const std::lock_guard lock(mutex_);
  entry->picture = picture;
  entry->bytes = picture->data.size();
  held_bytes_ += entry->bytes, ++held_;
  make_room();
  return picture;
}

void PixelCache::make_room() {
  while (held_bytes_ > most_bytes_ || held_ > most_pictures_) {
    auto oldest = entries_.end();
    for (auto it = entries_.begin(); it != entries_.end(); ++it) {
      if (it->second->bytes == 0 || it->second->last_use == uses_) continue;
      if (oldest == entries_.end() || it->second->last_use < oldest->second->last_use) oldest = it;
    }
    if (oldest == entries_.end()) return;
    held_bytes_ -= oldest->second->bytes, --held_;
    entries_.erase(oldest);
  }
}

}  // namespace collinea
