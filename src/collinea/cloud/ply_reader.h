// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "collinea/base/result.h"
#include "collinea/cloud/internal/cloud_point.h"

namespace collinea {

/// The points of a file that PlyWriter wrote, so many at a time: for clouds that memory does not hold.
class PlyReader {
 public:
  /// Errors: missing, not a file of PlyWriter.
  static Result<PlyReader> open(const std::filesystem::path& path);
  /// The next points; none at the end. Errors: truncated, disk.
  [[nodiscard]] Result<std::vector<CloudPoint>> read(std::size_t most);

 private:
  PlyReader(std::ifstream file, std::string name, std::uint64_t points)
      : file_(std::move(file)), name_(std::move(name)), left_(points) {}

  std::ifstream file_;
  std::string name_;
  std::uint64_t left_;  // not yet read
};

}  // namespace collinea
