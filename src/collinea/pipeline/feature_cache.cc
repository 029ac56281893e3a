// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/feature_cache.h"

namespace collinea {

Result<std::shared_ptr<const Features>> FeatureCache::of(ImageId image) {
  {
    const std::lock_guard lock(mutex_);
    if (const auto found = cached_.find(image); found != cached_.end()) {
      by_use_.splice(by_use_.begin(), by_use_, found->second.second);
      return found->second.first;
    }
  }
  COLLINEA_TRY(Features features, store_.read_features(image));
  auto shared = std::make_shared<const Features>(std::move(features));
  const std::lock_guard lock(mutex_);
  if (const auto found = cached_.find(image); found != cached_.end()) return found->second.first;
  by_use_.push_front(image);
  cached_[image] = {shared, by_use_.begin()};
  if (cached_.size() > max_images_) {
    cached_.erase(by_use_.back());
    by_use_.pop_back();
  }
  return shared;
}

}  // namespace collinea
