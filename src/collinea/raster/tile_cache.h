// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "collinea/base/result.h"
#include "collinea/raster/image_tiles.h"

namespace collinea {

/// An image whose tiles are wanted.
struct TiledImage {
  std::filesystem::path file;
  int width_px = 0, height_px = 0;  ///< as it was imported
  std::uint32_t number = 0;         ///< names it among those of a folder
};

struct CachedTile {
  std::string jpeg;
  std::string tag;  ///< changes with the file of the image
};

/// Tiles of images, made when they are first asked for and kept in a folder. Files are named by the number of the image
/// and by path, size and time of change of its file; those that were not used for longest go when the folder would hold
/// more than `most_bytes`. May be used from several threads: what several ask for at once is made once, at most two
/// files at the same time. An image that cannot be read is not tried again until its file changes.
class TileCache {
 public:
  static constexpr std::uint64_t kMostBytes = std::uint64_t(4) << 30;

  explicit TileCache(std::uint64_t most_bytes = kMostBytes) : most_bytes_(most_bytes) {}

  /// Errors: kNotFound, no such tile, no file of the image; those of write_tiles().
  [[nodiscard]] Result<CachedTile> tile(const std::filesystem::path& folder, const TiledImage& image,
                                        const TileAddress& address);

  /// Files made so far.
  [[nodiscard]] std::uint64_t made() const;

 private:
  [[nodiscard]] Result<> make(const TiledImage& image, TileLevels part, const std::filesystem::path& file);
  void remove_oldest(const std::filesystem::path& folder, const std::filesystem::path& but) const;

  const std::uint64_t most_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::set<std::filesystem::path> in_work_;  // files that some thread makes, or waits to make
  std::size_t making_ = 0;
  std::uint64_t made_ = 0;
  std::map<std::filesystem::path, Error> failures_;  // why a file could not be made
};

}  // namespace collinea
