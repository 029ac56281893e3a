// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <list>
#include <map>
#include <memory>
#include <mutex>

#include "collinea/io/project_store.h"

namespace collinea {

/// Features of the images used last, read from the project when needed. For several threads.
class FeatureCache {
 public:
  FeatureCache(const ProjectStore& store, std::size_t max_images) : store_(store), max_images_(max_images) {}

  /// Never null; an image without features has none.
  Result<std::shared_ptr<const Features>> of(ImageId image);

 private:
  const ProjectStore& store_;
  std::size_t max_images_;
  std::mutex mutex_;
  std::list<ImageId> by_use_;  // most recent first
  std::map<ImageId, std::pair<std::shared_ptr<const Features>, std::list<ImageId>::iterator>> cached_;
};

}  // namespace collinea
