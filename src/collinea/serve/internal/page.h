// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string_view>

namespace collinea {

/// A file of the built-in page (src/collinea/serve/page), which CMake makes part of the program.
struct PageFile {
  std::string_view type, text;
};

/// "" is the page itself; nothing when there is no such file.
[[nodiscard]] std::optional<PageFile> page_file(std::string_view name);

}  // namespace collinea
