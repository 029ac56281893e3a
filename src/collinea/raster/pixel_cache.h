// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <utility>

#include "collinea/base/id.h"
#include "collinea/base/result.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// Decodes the colours of an image (3 channels) at 1 / shrink of its size (1, 2, 4 or 8), as read_colour does. May be
/// called from several threads at once.
using PixelSource = std::function<Result<ColourImage>(ImageId image, int shrink)>;

/// Keeps the images used last, up to a number of bytes and of images. May be used from several threads at once; a
/// image that two of them want is decoded once.
class PixelCache {
 public:
  PixelCache(PixelSource source, std::size_t most_bytes, std::size_t most_images = ~std::size_t{0})
      : source_(std::move(source)), most_bytes_(most_bytes), most_images_(most_images) {}

  Result<std::shared_ptr<const ColourImage>> image_of(ImageId image, int shrink);

 private:
  struct Entry {
    std::mutex decoding;
    std::shared_ptr<const ColourImage> image;
    std::uint64_t last_use = 0;
    std::size_t bytes = 0;
  };
  using Key = std::pair<ImageId, int>;
  void make_room();  // mutex_ is held

  PixelSource source_;
  std::size_t most_bytes_, most_images_, cached_bytes_ = 0, cached_ = 0;
  std::uint64_t uses_ = 0;
  std::mutex mutex_;
  std::map<Key, std::shared_ptr<Entry>> entries_;
};

}  // namespace collinea
