// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "collinea/base/result.h"

namespace collinea {

/// A 64-bit fingerprint built up from pieces (FNV-1a with a final mix). Not for security: it tells whether inputs
/// changed.
class Hash {
 public:
  Hash& add(std::span<const std::byte> bytes);
  Hash& add(std::string_view text);  ///< the text and its length
  Hash& add(std::uint64_t value);
  template <std::floating_point T>
  Hash& add(T value) = delete;  ///< would lose its fraction: add its bytes
  [[nodiscard]] std::uint64_t value() const;
  [[nodiscard]] std::string hex() const;  ///< 16 digits

 private:
  std::uint64_t state_ = 0xcbf29ce484222325u;
};

/// The fingerprint of a file's bytes.
[[nodiscard]] Result<std::uint64_t> hash_of_file(const std::filesystem::path& path);

}  // namespace collinea
