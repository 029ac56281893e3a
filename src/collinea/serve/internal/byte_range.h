// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>

namespace collinea {

/// What a header `Range` asks of a file.
struct ByteRange {
  enum class Kind { kWhole, kPart, kUnsatisfiable };
  Kind kind = Kind::kWhole;
  std::uint64_t first = 0, size = 0;  ///< of a part

  friend bool operator==(const ByteRange&, const ByteRange&) = default;
};

/// One range of bytes (RFC 9110, 14.1.2): "bytes=0-99", "bytes=100-", "bytes=-100". No header or another unit: the
/// whole file. Several ranges, what is no range and what lies beyond the file cannot be satisfied.
[[nodiscard]] ByteRange asked_range(std::string_view header, std::uint64_t file_size);

}  // namespace collinea
