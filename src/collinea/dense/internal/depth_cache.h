// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>

#include "collinea/dense/depth_map.h"

namespace collinea {

/// The depth maps read last, up to a number of bytes. Not thread-safe.
class DepthCache {
 public:
  DepthCache(DepthStore& store, std::size_t max_bytes) : store_(store), max_bytes_(max_bytes) {}

  Result<std::shared_ptr<const DepthMap>> map(ImageId image);

 private:
  struct Entry {
    std::shared_ptr<const DepthMap> map;
    std::list<ImageId>::iterator use;
  };
  DepthStore& store_;
  std::size_t max_bytes_, bytes_ = 0;
  std::map<ImageId, Entry> entries_;
  std::list<ImageId> by_use_;  ///< latest first
};

}  // namespace collinea
