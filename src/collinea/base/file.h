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

/// All bytes of a file. Errors: missing, a folder or a device, not readable, larger than `limit_bytes`.
[[nodiscard]] Result<std::string> read_file(const std::filesystem::path& path,
                                            std::uint64_t limit_bytes = std::uint64_t{1} << 32);

/// Whether there is a file or folder of this name; what cannot be looked at counts as not there.
[[nodiscard]] bool is_there(const std::filesystem::path& path);

/// Removes a file, if it is there. Errors: it stays.
Result<> remove_file(const std::filesystem::path& path);

/// A file being written under a temporary name beside its final path; it takes its own name by finish(), and is removed
/// when that never comes. Write errors are remembered and reported by finish().
class OutputFile {
 public:
  /// Errors: the folder is missing and cannot be made, or is not writable.
  static Result<OutputFile> create(const std::filesystem::path& path);

  void write(std::string_view bytes);
  void write_at(std::uint64_t offset, std::string_view bytes);  ///< over what is there; then back to the end
  [[nodiscard]] std::uint64_t size() const { return size_; }
  Result<> finish();

  OutputFile(OutputFile&& other) noexcept;
  OutputFile& operator=(OutputFile&&) = delete;
  ~OutputFile();

 private:
  OutputFile() = default;
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::filesystem::path path_, temporary_;
  std::unique_ptr<std::FILE, Close> file_;
  std::uint64_t size_ = 0;
  bool failed_ = false;
};

/// Writes a whole file, atomically.
[[nodiscard]] Result<> write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace collinea
