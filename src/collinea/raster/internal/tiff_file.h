// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "collinea/base/result.h"

struct tiff;

namespace collinea {

/// An open file of libtiff that prints nothing and keeps its first error message. Internal to the module.
class TiffFile {
 public:
  TiffFile(const std::filesystem::path& path, const char* mode);
  ~TiffFile();
  TiffFile(const TiffFile&) = delete;
  TiffFile& operator=(const TiffFile&) = delete;

  [[nodiscard]] tiff* get() const { return tiff_; }  ///< null when it could not be opened
  void close();
  [[nodiscard]] const std::string& message() const { return *message_; }
  [[nodiscard]] tl::unexpected<Error> error() const;

 private:
  std::unique_ptr<std::string> message_;
  tiff* tiff_ = nullptr;
};

}  // namespace collinea
