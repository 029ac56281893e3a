// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/file.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"

namespace collinea {

/// What a point record of LAS 1.4 consists of: the 30 bytes of point format 6, colour (6 bytes; format 7), near
/// infrared (2 bytes; format 8), extra bytes.
struct LazLayout {
  bool colour = false, infrared = false;
  std::size_t extra_bytes = 0;
  [[nodiscard]] std::size_t record_bytes() const { return 30 + (colour ? 6 : 0) + (infrared ? 2 : 0) + extra_bytes; }
};

/// LAZ 1.4: point records compressed in chunks that stand alone, each attribute in a layer of its own ("layered
/// chunked", items POINT14, RGB14, BYTE14, version 3). Format: LAZ specification 1.4 R1 (ASPRS, 2021);
/// docs/theory/laz.md. Written are clouds of images: every point the only return, on one channel, without time,
/// all such attributes as in the first record. `records` must hold at least one record.
[[nodiscard]] std::string compress_laz_chunk(std::string_view records, const LazLayout& layout);

/// Its inverse. Layers of what images do not give (intensity, flags, scan angle, user data, source, time,
/// infrared) are passed over: these attributes are as in the chunk's first record. Errors: damaged; several returns or
/// channels.
[[nodiscard]] Result<std::string> expand_laz_chunk(std::string_view chunk, std::uint64_t points,
                                                   const LazLayout& layout);

struct LazChunk {
  std::uint64_t at = 0, bytes = 0, points = 0;  ///< in the file
};

/// How a file is cut: chunks of 50,000 points, the last one shorter, or of any number each.
enum class LazChunks { kOfOneSize, kOfAnySize };

/// The content of the record "laszip encoded" 22204, for layouts without infrared.
[[nodiscard]] std::string laz_description(const LazLayout& layout, LazChunks chunks = LazChunks::kOfOneSize);

/// To be called where the points begin: leaves bytes for the offset of the chunk table. Returns where that is.
std::uint64_t begin_laz_chunks(OutputFile& file);

/// The chunk table, and its offset at `begin`.
void write_laz_chunk_table(OutputFile& file, std::uint64_t begin, const std::vector<LazChunk>& chunks, LazChunks cut);

/// Takes records and writes chunks of 50,000 points, several of them compressed side by side; the bytes do not depend
/// on run.threads. In memory: 50,000 records for each thread.
class LazStream {
 public:
  LazStream(const LazLayout& layout, const Run& run) : layout_(layout), run_(run) {}
  void begin(OutputFile& file) { begin_ = begin_laz_chunks(file); }
  Result<> add(std::string_view records, OutputFile& file);  ///< errors: run was stopped
  Result<> finish(OutputFile& file);                         ///< the last chunk and the chunk table

 private:
  Result<> write_chunks(OutputFile& file, bool all);
  LazLayout layout_;
  Run run_;
  std::string waiting_;
  std::vector<LazChunk> chunks_;
  std::uint64_t begin_ = 0;
};

/// What the record "laszip encoded" says, and where the chunks lie. `bytes_at(offset, size)` reads the file.
/// Errors: another compression, versions before LAS 1.4's, damaged, truncated.
using BytesAt = std::function<Result<std::string>(std::uint64_t offset, std::uint64_t size)>;
[[nodiscard]] Result<std::vector<LazChunk>> laz_chunks(std::string_view description, const LazLayout& layout,
                                                       std::uint64_t points_at, std::uint64_t points,
                                                       std::uint64_t file_size, const BytesAt& bytes_at);

}  // namespace collinea
