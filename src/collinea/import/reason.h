// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace collinea {

/// Why a file was left out, without its name, which stands beside it in every list: "reading /a/b.jpg: /a/b.jpg is
/// empty" becomes "is empty".
[[nodiscard]] inline std::string reason_without_name(std::string message, const std::filesystem::path& path) {
  for (const std::string& start : {"reading " + path.string() + ": ", path.string() + ": ", path.string() + " "})
    if (message.starts_with(start)) message.erase(0, start.size());
  return message;
}

}  // namespace collinea
