// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>

#include "collinea/base/id.h"
#include "collinea/base/result.h"

namespace collinea {

/// What belongs to each of the images used last, read when needed. For several threads.
template <class Value>
class ImageCache {
 public:
  using Read = std::function<Result<Value>(ImageId image)>;

  /// `read` is called from several threads.
  ImageCache(Read read, std::size_t max_images) : read_(std::move(read)), max_images_(max_images) {}

  /// Never null. Errors: those of reading.
  Result<std::shared_ptr<const Value>> of(ImageId image) {
    {
      const std::lock_guard lock(mutex_);
      if (const auto found = cached_.find(image); found != cached_.end()) {
        by_use_.splice(by_use_.begin(), by_use_, found->second.second);
        return found->second.first;
      }
    }
    COLLINEA_TRY(Value value, read_(image));
    auto shared = std::make_shared<const Value>(std::move(value));
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

 private:
  Read read_;
  std::size_t max_images_;
  std::mutex mutex_;
  std::list<ImageId> by_use_;  // most recent first
  std::map<ImageId, std::pair<std::shared_ptr<const Value>, typename std::list<ImageId>::iterator>> cached_;
};

}  // namespace collinea
