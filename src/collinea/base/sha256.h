// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "collinea/base/result.h"
#include "collinea/base/run.h"

namespace collinea {

/// SHA-256 (FIPS 180-4), built up from pieces. Unlike Hash nobody can make other bytes with the same one on purpose, so
/// that it may stand under a signature; about 1.5 GB/s on processors with instructions for it, a quarter elsewhere.
class Sha256 {
 public:
  Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  ~Sha256();
  Sha256& add(std::string_view bytes);
  [[nodiscard]] std::string hex();  ///< 64 digits; afterwards nothing can be added

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Of all bytes of a file, as `sha256sum` prints it. Reads it in pieces of 1 MiB. Errors: missing, not a regular file,
/// not readable, kCancelled.
[[nodiscard]] Result<std::string> sha256_of_file(const std::filesystem::path& path, const Run& run);

}  // namespace collinea
