// SPDX-License-Identifier: Apache-2.0
#include "collinea/cloud/internal/laz.h"

#include <algorithm>

#include "collinea/base/packed.h"
#include "collinea/base/parallel.h"
#include "collinea/cloud/internal/laz_coder.h"

namespace collinea {
namespace {

constexpr std::uint32_t kChunkPoints = 50'000;  // customary: all readers take it in memory
constexpr std::uint32_t kVariable = ~0u;
constexpr std::uint64_t kMaxChunkBytes = 256 << 20;  // expanded, of foreign files: what is taken into memory
constexpr std::uint16_t kLayered = 3, kVersion = 3;
constexpr std::uint16_t kPoint14 = 10, kRgb14 = 11, kRgbNir14 = 12, kByte14 = 14;

struct Item {
  std::uint16_t type, size;
};

std::vector<Item> items_of(const LazLayout& layout) {
  std::vector<Item> items = {{kPoint14, 30}};
  if (layout.infrared)
    items.push_back({kRgbNir14, 8});
  else if (layout.colour)
    items.push_back({kRgb14, 6});
  if (layout.extra_bytes) items.push_back({kByte14, std::uint16_t(layout.extra_bytes)});
  return items;
}

Result<std::uint32_t> chunk_points_of(std::string_view description, const LazLayout& layout) {
  Unpacker d(description);
  const auto compressor = d.get<std::uint16_t>();
  d.get_bytes(10);  // coder, version of the writer, options
  const auto chunk_points = d.get<std::uint32_t>();
  d.get_bytes(16);
  const auto count = d.get<std::uint16_t>();
  const std::vector<Item> items = items_of(layout);
  bool known = compressor == kLayered && count == items.size();
  for (const Item& item : items) {
    known = d.get<std::uint16_t>() == item.type && known;
    known = d.get<std::uint16_t>() == item.size && known;
    const auto version = d.get<std::uint16_t>();
    known = known && (version == kVersion || version == 4);  // 4 differs with several channels only
  }
  if (!d.ok()) return fail(Errc::kBadFormat, "damaged: it is compressed but does not say how");
  if (!known) return fail(Errc::kUnsupported, "a form of LAZ that is not read here: only that of LAS 1.4 is");
  if (chunk_points == 0) return fail(Errc::kBadFormat, "damaged: chunks of no points");
  return chunk_points;
}

}  // namespace

std::string laz_description(const LazLayout& layout, LazChunks chunks) {
  Packer d;
  d.put(kLayered);
  d.put(std::uint16_t{0});  // arithmetic coder
  d.put(std::uint8_t{3});   // version of the format's own software that writes the same
  d.put(std::uint8_t{4});
  d.put(std::uint16_t{0});
  d.put(std::uint32_t{0});  // options
  d.put(chunks == LazChunks::kOfAnySize ? kVariable : kChunkPoints);
  d.put(std::int64_t{-1});  // no special records
  d.put(std::int64_t{-1});
  const std::vector<Item> items = items_of(layout);
  d.put(std::uint16_t(items.size()));
  for (const Item& item : items) {
    d.put(item.type);
    d.put(item.size);
    d.put(kVersion);
  }
  return d.bytes();
}

std::uint64_t begin_laz_chunks(OutputFile& file) {
  const std::uint64_t begin = file.size();
  file.write(std::string(8, '\0'));
  return begin;
}

void write_laz_chunk_table(OutputFile& file, std::uint64_t begin, const std::vector<LazChunk>& chunks, LazChunks cut) {
  Packer table_at;
  table_at.put(std::int64_t(file.size()));
  file.write_at(begin, table_at.bytes());
  Packer table;
  table.put(std::uint32_t{0});  // version
  table.put(std::uint32_t(chunks.size()));
  if (!chunks.empty()) {
    ArithmeticEncoder coder;
    NumberModel numbers(2);
    std::int32_t last_points = 0, last_bytes = 0;
    for (const LazChunk& chunk : chunks) {
      if (cut == LazChunks::kOfAnySize) last_points = numbers.code(coder, last_points, std::int32_t(chunk.points), 0);
      last_bytes = numbers.code(coder, last_bytes, std::int32_t(chunk.bytes), 1);
    }
    table.put_bytes(coder.finish());
  }
  file.write(table.bytes());
}

Result<> LazStream::add(std::string_view records, OutputFile& file) {
  waiting_ += records;
  const std::size_t side_by_side = std::size_t(std::max(1, run_.threads));
  if (waiting_.size() < side_by_side * kChunkPoints * layout_.record_bytes()) return {};
  return write_chunks(file, false);
}

Result<> LazStream::write_chunks(OutputFile& file, bool all) {
  const std::size_t chunk_bytes = kChunkPoints * layout_.record_bytes();
  const std::size_t count = all ? (waiting_.size() + chunk_bytes - 1) / chunk_bytes : waiting_.size() / chunk_bytes;
  std::vector<std::string> chunks(count);
  const std::string_view waiting = waiting_;
  parallel_for(run_, count, [&](std::size_t i) {
    chunks[i] = compress_laz_chunk(waiting.substr(i * chunk_bytes, chunk_bytes), layout_);
  });
  if (run_.stopped()) return fail(Errc::kCancelled, "stopped");
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t records = waiting.substr(i * chunk_bytes, chunk_bytes).size() / layout_.record_bytes();
    chunks_.push_back({file.size(), chunks[i].size(), records});
    file.write(chunks[i]);
  }
  waiting_.erase(0, count * chunk_bytes);
  return {};
}

Result<> LazStream::finish(OutputFile& file) {
  COLLINEA_TRY(write_chunks(file, true));
  write_laz_chunk_table(file, begin_, chunks_, LazChunks::kOfOneSize);
  return {};
}

Result<std::vector<LazChunk>> laz_chunks(std::string_view description, const LazLayout& layout, std::uint64_t points_at,
                                         std::uint64_t points, std::uint64_t file_size, const BytesAt& bytes_at) {
  COLLINEA_TRY(const std::uint32_t chunk_points, chunk_points_of(description, layout));
  if (points == 0) return std::vector<LazChunk>{};
  COLLINEA_TRY(const std::string begin, bytes_at(points_at, 8));
  const auto table_at = Unpacker(begin).get<std::uint64_t>();
  COLLINEA_TRY(const std::string head, bytes_at(table_at, 8));
  Unpacker table_head(head);
  table_head.get<std::uint32_t>();
  const auto count = table_head.get<std::uint32_t>();
  const auto damaged = [] { return fail(Errc::kBadFormat, "truncated or damaged: its chunk table is wrong"); };
  if (count > file_size / layout.record_bytes()) return damaged();
  // Sizes and counts take no more than 9 bytes for each chunk; what follows the table does no harm.
  const std::uint64_t table_bytes = std::min<std::uint64_t>(file_size - table_at - 8, 64 + 18 * std::uint64_t(count));
  COLLINEA_TRY(const std::string table, bytes_at(table_at + 8, table_bytes));
  ArithmeticDecoder coder(table);
  NumberModel numbers(2);
  std::vector<LazChunk> chunks;
  std::uint64_t at = points_at + 8, left = points;
  std::int32_t last_points = 0, last_bytes = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    if (chunk_points == kVariable) last_points = numbers.code(coder, last_points, 0, 0);
    last_bytes = numbers.code(coder, last_bytes, 0, 1);
    const std::uint64_t here =
        chunk_points == kVariable ? std::uint32_t(last_points) : std::min<std::uint64_t>(chunk_points, left);
    const std::uint64_t bytes = std::uint32_t(last_bytes);
    if (!coder.ok() || here == 0 || here > left || here > kMaxChunkBytes / layout.record_bytes() || at > table_at ||
        bytes > table_at - at)
      return damaged();
    chunks.push_back({at, bytes, here});
    at += bytes;
    left -= here;
  }
  if (left != 0) return damaged();
  return chunks;
}

}  // namespace collinea
