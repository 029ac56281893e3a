// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "collinea/base/result.h"

namespace collinea {

/// Bytes on disk that need not stay in memory while they are worked on. The file has no name, so that nothing is left
/// of it whatever happens.
class RecordSpool {
 public:
  /// Beside `file`, where there must be room. Errors: not writable.
  static Result<RecordSpool> create(const std::filesystem::path& file);
  void append(std::string_view bytes);
  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// `bytes` from `at`; from several threads at once, but not while some are appended. Errors: something could not be
  /// written (full disk), or not all of it is there.
  [[nodiscard]] Result<std::string> read(std::uint64_t at, std::uint64_t bytes) const;

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::unique_ptr<std::FILE, Close> file_;
  std::string name_;
  std::uint64_t size_ = 0;
  int failure_ = 0;  // errno of the first append that failed
};

}  // namespace collinea
