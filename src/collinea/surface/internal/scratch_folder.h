// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "collinea/base/result.h"

namespace collinea {

/// A folder for what memory does not hold. It is made when it is first needed, and goes in the end when it was made
/// here and nobody else has put anything into it.
class ScratchFolder {
 public:
  explicit ScratchFolder(std::filesystem::path path);
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  /// Errors: it cannot be made.
  Result<> make();
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
  bool made_ = false;
};

/// That a file of it cannot be written, for the reason that the system has just given.
[[nodiscard]] tl::unexpected<Error> cannot_write(const std::filesystem::path& file);

}  // namespace collinea
