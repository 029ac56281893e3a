// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace collinea {

/// A file of the built-in page, which CMake makes of web/ and puts into the program.
struct PageFile {
  std::string_view name, type;
  std::string_view bytes;
  std::string_view zipped;  ///< the same as gzip has it; empty where that is no smaller
};

/// "" is the page itself, others are named by their path: "assets/x.js"; nothing when there is no such file.
[[nodiscard]] std::optional<PageFile> page_file(std::string_view name);

}  // namespace collinea
