// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "collinea/base/result.h"

namespace collinea {

/// Makes the folder that results go to, with those above it, where it is missing. Error: it cannot be made.
[[nodiscard]] inline Result<> make_out_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) return fail(Errc::kBadInput, "cannot make " + folder.string() + ": " + error.message(), {"out"_option});
  return {};
}

}  // namespace collinea
