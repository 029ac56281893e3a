// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/image_tiles.h"

#include <algorithm>
#include <cstdio>
#include <memory>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/packed.h"
#include "collinea/raster/codec.h"
#include "collinea/raster/image_file.h"
#include "collinea/raster/jpeg_reader.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

constexpr std::string_view kMagic = "collinea tiles 1";
constexpr std::size_t kHeadBytes = kMagic.size() + 4 * sizeof(std::uint32_t);
constexpr std::uint64_t kLargestTile = 1 << 20;  // bytes; a tile of noise at the best quality has a quarter of that
constexpr int kOverviewQuality = 85, kFineQuality = 92;  // targets are looked at in the fine ones

int reduced(int size, int halvings) {
  return int((std::int64_t(size) + (std::int64_t(1) << halvings) - 1) >> halvings);
}
int tiles_along(int size) { return (size + kTilePx - 1) / kTilePx; }

/// The levels of a part, and where their tiles stand in its index: level by level, row by row.
struct PartLayout {
  int width_px, height_px, first, last, levels;

  PartLayout(int width, int height, TileLevels part) : width_px(width), height_px(height) {
    levels = tile_levels(width, height);
    const int fine = std::max(0, levels - kFineLevels);
    first = part == TileLevels::kFine ? fine : 0;
    last = part == TileLevels::kFine ? levels - 1 : fine - 1;
  }
  [[nodiscard]] int width(int level) const { return reduced(width_px, levels - 1 - level); }
  [[nodiscard]] int height(int level) const { return reduced(height_px, levels - 1 - level); }
  [[nodiscard]] std::size_t tiles_of(int level) const {
    return std::size_t(tiles_along(width(level))) * std::size_t(tiles_along(height(level)));
  }
  [[nodiscard]] std::size_t index_of(const TileAddress& tile) const {
    std::size_t index = 0;
    for (int level = first; level < tile.level; ++level) index += tiles_of(level);
    return index + std::size_t(tile.row) * std::size_t(tiles_along(width(tile.level))) + std::size_t(tile.column);
  }
  [[nodiscard]] std::size_t count() const { return index_of({last + 1, 0, 0}); }
  [[nodiscard]] std::string head() const {
    Packer packer;
    packer.put_bytes(kMagic);
    for (const int value : {width_px, height_px, first, last}) packer.put(std::uint32_t(value));
    return packer.bytes();
  }
};

Raster<std::uint8_t> cut(const Raster<std::uint8_t>& rows, int left, int width) {
  Raster<std::uint8_t> out(width, rows.height, rows.channels);
  const std::size_t channels = std::size_t(rows.channels);
  for (int y = 0; y < rows.height; ++y)
    std::copy_n(rows.row(y) + std::size_t(left) * channels, std::size_t(width) * channels, out.row(y));
  return out;
}

/// Takes the rows of the finest level of a part from the top down and writes the tiles of all its levels.
class TileWriter {
 public:
  TileWriter(OutputFile file, const PartLayout& layout, int quality)
      : file_(std::move(file)),
        layout_(layout),
        quality_(quality),
        pending_(std::size_t(layout.last + 1)),
        entries_(layout.count()),
        row_(std::size_t(layout.last + 1)) {
    file_.write(layout_.head());
    file_.write(std::string(2 * sizeof(std::uint64_t) * entries_.size(), '\0'));
  }

  Result<> add(const Raster<std::uint8_t>& rows) { return add(rows, layout_.last); }

  Result<> finish() {
    Packer index;
    for (const auto& [offset, size] : entries_) {
      index.put(offset);
      index.put(size);
    }
    file_.write_at(kHeadBytes, index.bytes());
    return file_.finish();
  }

 private:
  Result<> add(const Raster<std::uint8_t>& rows, int level) {
    Raster<std::uint8_t>& pending = pending_[std::size_t(level)];
    for (int y = 0; y < rows.height;) {
      if (pending.empty()) pending = Raster<std::uint8_t>(rows.width, 0, rows.channels);
      const int count = std::min(kTilePx - pending.height, rows.height - y);
      pending.data.insert(pending.data.end(), rows.row(y),
                          rows.row(y) + std::ptrdiff_t(count) * rows.width * rows.channels);
      pending.height += count;
      y += count;
      const int done = row_[std::size_t(level)] * kTilePx + pending.height;
      if (pending.height == kTilePx || done == layout_.height(level)) COLLINEA_TRY(write_row(level));
    }
    return {};
  }

  // A row of tiles is complete: it goes out, and half of it to the next level.
  Result<> write_row(int level) {
    const Raster<std::uint8_t> rows = std::exchange(pending_[std::size_t(level)], {});
    const int row = row_[std::size_t(level)]++;
    for (int column = 0; column < tiles_along(rows.width); ++column) {
      const int left = column * kTilePx;
      COLLINEA_TRY(const std::string jpeg,
                   encode_jpeg(cut(rows, left, std::min(kTilePx, rows.width - left)), quality_));
      entries_[layout_.index_of({level, column, row})] = {file_.size(), jpeg.size()};
      file_.write(jpeg);
    }
    return level > layout_.first ? add(half(rows), level - 1) : Result<>{};
  }

  OutputFile file_;
  PartLayout layout_;
  int quality_;
  std::vector<Raster<std::uint8_t>> pending_;                     // by level: rows that do not make a row of tiles yet
  std::vector<std::pair<std::uint64_t, std::uint64_t>> entries_;  // offset and size of each tile
  std::vector<int> row_;                                          // by level: the next row of tiles
};

Result<> check_stated_size(const std::filesystem::path& image, int width, int height, const PartLayout& layout) {
  if (width == layout.width_px && height == layout.height_px) return {};
  const auto text = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  return fail(Errc::kBadFormat, image.string() + ": it has " + text(width, height) + " pixels, not " +
                                    text(layout.width_px, layout.height_px) + " as when it was imported");
}

Result<> add_jpeg(const std::filesystem::path& image, const PartLayout& layout, TileLevels part, TileWriter& writer) {
  COLLINEA_TRY(JpegReader reader, JpegReader::open(image, part == TileLevels::kOverview ? 1 << kFineLevels : 1));
  COLLINEA_TRY(check_stated_size(image, reader.full_width_px(), reader.full_height_px(), layout));
  while (!reader.at_end()) {
    COLLINEA_TRY(const auto rows, reader.read(kTilePx));
    COLLINEA_TRY(writer.add(rows));
  }
  return {};
}

Result<> add_other(const std::filesystem::path& image, const PartLayout& layout, TileLevels part, TileWriter& writer) {
  COLLINEA_TRY(const ColourImage whole, read_colour(image));
  COLLINEA_TRY(check_stated_size(image, whole.width, whole.height, layout));
  return writer.add(part == TileLevels::kOverview ? shrunk(whole, 1 << kFineLevels) : whole);
}

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

std::string bytes_at(std::FILE* file, std::uint64_t offset, std::size_t count) {
  std::string bytes(count, '\0');
  if (::fseeko(file, off_t(offset), SEEK_SET) != 0) return {};
  bytes.resize(std::fread(bytes.data(), 1, count, file));
  return bytes;
}

}  // namespace

int tile_levels(int width_px, int height_px) {
  int levels = 1;
  while (reduced(std::max(width_px, height_px), levels - 1) > kTilePx) ++levels;
  return levels;
}

bool has_tile(int width_px, int height_px, const TileAddress& tile) {
  const int levels = tile_levels(width_px, height_px);
  if (tile.level < 0 || tile.level >= levels || tile.column < 0 || tile.row < 0) return false;
  const int halvings = levels - 1 - tile.level;
  return tile.column < tiles_along(reduced(width_px, halvings)) && tile.row < tiles_along(reduced(height_px, halvings));
}

TileLevels part_of_level(int levels, int level) {
  return level < levels - kFineLevels ? TileLevels::kOverview : TileLevels::kFine;
}

Result<> write_tiles(const std::filesystem::path& image, int width_px, int height_px, TileLevels part,
                     const std::filesystem::path& file) {
  const PartLayout layout(width_px, height_px, part);
  COLLINEA_CHECK(layout.first <= layout.last);
  COLLINEA_TRY(const FileKind kind, kind_of_file(image));
  COLLINEA_TRY(OutputFile out, OutputFile::create(file));
  TileWriter writer(std::move(out), layout, part == TileLevels::kFine ? kFineQuality : kOverviewQuality);
  COLLINEA_TRY((kind == FileKind::kJpeg ? add_jpeg : add_other)(image, layout, part, writer));
  return writer.finish();
}

Result<std::string> read_tile(const std::filesystem::path& file, int width_px, int height_px, const TileAddress& tile) {
  COLLINEA_CHECK(has_tile(width_px, height_px, tile));
  const PartLayout layout(width_px, height_px, part_of_level(tile_levels(width_px, height_px), tile.level));
  const std::unique_ptr<std::FILE, CloseFile> open(std::fopen(file.c_str(), "rbe"));
  if (!open) return fail(Errc::kNotFound, file.string() + ": there is no such file");
  const std::string head = layout.head();
  const auto damaged = [&] { return fail(Errc::kBadFormat, file.string() + ": damaged, or tiles of another image"); };
  if (bytes_at(open.get(), 0, head.size()) != head) return damaged();
  const std::string index = bytes_at(open.get(), kHeadBytes + 16 * layout.index_of(tile), 16);
  Unpacker unpacker(index);
  std::uint64_t offset = 0, size = 0;
  unpacker.get(offset);
  unpacker.get(size);
  if (index.size() != 16 || size == 0 || size > kLargestTile || offset > (std::uint64_t(1) << 40)) return damaged();
  std::string jpeg = bytes_at(open.get(), offset, std::size_t(size));
  if (jpeg.size() != size) return damaged();
  return jpeg;
}

}  // namespace collinea
