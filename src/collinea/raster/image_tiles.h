// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "collinea/base/result.h"

// Images as tiles for those who look at a part of them. Level Z of an image with n levels is the image reduced by
// 2^(n - 1 - Z), its size rounded up; level 0 fits one tile. The tiles of an image lie in two files: the overview,
// which a JPEG decoder gives at a quarter of the size, and the two finest levels.
namespace collinea {

inline constexpr int kTilePx = 256;  ///< side of a tile; those at the right and lower rim are smaller
inline constexpr int kFineLevels = 2;

/// Of an image: 1 where it fits one tile.
[[nodiscard]] int tile_levels(int width_px, int height_px);

struct TileAddress {
  int level = 0, column = 0, row = 0;
};
/// Whether an image of this size has such a tile.
[[nodiscard]] bool has_tile(int width_px, int height_px, const TileAddress& tile);

/// Which of the files of an image.
enum class TileLevels : std::uint8_t { kOverview, kFine };
/// Where a level lies.
[[nodiscard]] TileLevels part_of_level(int levels, int level);

/// Makes the tiles of a part of an image (JPEG; PNG and TIFF, whose part alone may be either) and writes them to a
/// file, atomically. JPEG is decoded in strips: memory for some 800 rows of it. Others lie in memory as a whole.
/// Errors: those of reading an image; kBadFormat when the image is not of the stated size; disk.
[[nodiscard]] Result<> write_tiles(const std::filesystem::path& image, int width_px, int height_px, TileLevels part,
                                   const std::filesystem::path& file);

/// A tile of such a file, as a JPEG. Errors: kNotFound, no file; kBadFormat, it is not of an image of this size, or
/// damaged.
[[nodiscard]] Result<std::string> read_tile(const std::filesystem::path& file, int width_px, int height_px,
                                            const TileAddress& tile);

}  // namespace collinea
