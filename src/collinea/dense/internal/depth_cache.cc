// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/depth_cache.h"

namespace collinea {
namespace {

std::size_t bytes_of(const DepthMap& map) { return (map.depth.data.size() + map.sigma.data.size()) * sizeof(float); }

}  // namespace

Result<std::shared_ptr<const DepthMap>> DepthCache::map(ImageId image) {
  if (const auto found = entries_.find(image); found != entries_.end()) {
    by_use_.splice(by_use_.begin(), by_use_, found->second.use);
    return found->second.map;
  }
  COLLINEA_TRY(DepthMap read, store_.read(image));
  COLLINEA_CHECK(read.depth.data.size() == read.sigma.data.size());
  auto kept = std::make_shared<const DepthMap>(std::move(read));
  bytes_ += bytes_of(*kept);
  by_use_.push_front(image);
  entries_[image] = {kept, by_use_.begin()};
  while (bytes_ > max_bytes_ && by_use_.size() > 1) {
    const auto oldest = entries_.find(by_use_.back());
    bytes_ -= bytes_of(*oldest->second.map);
    entries_.erase(oldest);
    by_use_.pop_back();
  }
  return kept;
}

}  // namespace collinea
