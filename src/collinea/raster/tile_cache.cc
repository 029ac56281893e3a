// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/tile_cache.h"

#include <algorithm>
#include <chrono>
#include <new>
#include <vector>

#include "collinea/base/hash.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostAtOnce = 2;  // files that are made: each takes memory for strips of an image
constexpr std::size_t kMostFailures = 10'000;
constexpr std::chrono::minutes kUsed(10);  // a use after that long is noted in the file's time

// The version of an image file; nothing when there is none.
Result<std::string> tag_of(const fs::path& file) {
  std::error_code error;
  const auto bytes = fs::file_size(file, error);
  const auto changed = error ? fs::file_time_type() : fs::last_write_time(file, error);
  if (error) return fail(Errc::kNotFound, file.string() + ": " + error.message());
  return Hash()
      .add(file.native())
      .add(std::uint64_t(bytes))
      .add(std::uint64_t(changed.time_since_epoch().count()))
      .hex();
}

void note_use(const fs::path& file) {
  std::error_code error;
  const auto now = fs::file_time_type::clock::now();
  const auto last = fs::last_write_time(file, error);
  if (!error && now - last > kUsed) fs::last_write_time(file, now, error);
}

struct Kept {
  fs::file_time_type used;
  fs::path path;
  std::uint64_t bytes = 0;
};

std::vector<Kept> kept_in(const fs::path& folder) {
  std::vector<Kept> all;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    std::error_code failed;
    if (entry->path().extension() != ".tiles" || !entry->is_regular_file(failed)) continue;
    const Kept one{entry->last_write_time(failed), entry->path(), entry->file_size(failed)};
    if (!failed) all.push_back(one);
  }
  return all;
}

}  // namespace

Result<CachedTile> TileCache::tile(const fs::path& folder, const TiledImage& image, const TileAddress& address) {
  if (!has_tile(image.width_px, image.height_px, address)) return fail(Errc::kNotFound, "the image has no such tile");
  COLLINEA_TRY(const std::string tag, tag_of(image.file));
  const TileLevels part = part_of_level(tile_levels(image.width_px, image.height_px), address.level);
  const fs::path file = folder / (std::to_string(image.number) + "-" + tag +
                                  (part == TileLevels::kFine ? "-fine.tiles" : "-overview.tiles"));
  Result<std::string> jpeg = read_tile(file, image.width_px, image.height_px, address);
  if (!jpeg) {  // not made yet, removed, or damaged
    COLLINEA_TRY(make(image, part, file));
    COLLINEA_TRY(jpeg, read_tile(file, image.width_px, image.height_px, address));
  } else {
    note_use(file);
  }
  return CachedTile{*std::move(jpeg), tag};
}

Result<> TileCache::make(const TiledImage& image, TileLevels part, const fs::path& file) {
  std::unique_lock lock(mutex_);
  if (in_work_.contains(file)) {
    changed_.wait(lock, [&] { return !in_work_.contains(file); });
    if (const auto failure = failures_.find(file); failure != failures_.end()) return tl::unexpected(failure->second);
    return {};
  }
  if (const auto failure = failures_.find(file); failure != failures_.end()) return tl::unexpected(failure->second);
  in_work_.insert(file);
  changed_.wait(lock, [&] { return making_ < kMostAtOnce; });
  ++making_;
  lock.unlock();
  Result<> made = [&]() -> Result<> {
    try {
      return write_tiles(image.file, image.width_px, image.height_px, part, file);
    } catch (const std::bad_alloc&) {
      return fail(Errc::kUnsupported, image.file.string() + ": not enough memory for this image");
    }
  }();
  if (made) remove_oldest(file.parent_path(), file);
  lock.lock();
  --making_;
  ++made_;
  in_work_.erase(file);
  if (failures_.size() >= kMostFailures) failures_.clear();
  // Only what lies in the image itself stays as it is: disks get free again.
  if (!made && made.error().code == Errc::kBadFormat) failures_.emplace(file, made.error());
  changed_.notify_all();
  return made;
}

std::uint64_t TileCache::made() const {
  const std::lock_guard lock(mutex_);
  return made_;
}

void TileCache::remove_oldest(const fs::path& folder, const fs::path& but) const {
  std::vector<Kept> all = kept_in(folder);
  std::uint64_t bytes = 0;
  for (const Kept& one : all) bytes += one.bytes;
  std::sort(all.begin(), all.end(),
            [](const Kept& a, const Kept& b) { return a.used != b.used ? a.used < b.used : a.path < b.path; });
  for (const Kept& one : all) {
    if (bytes <= most_bytes_) return;
    if (one.path == but) continue;
    std::error_code ignored;
    if (fs::remove(one.path, ignored)) bytes -= one.bytes;
  }
}

}  // namespace collinea
