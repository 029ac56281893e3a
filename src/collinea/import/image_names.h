// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "collinea/base/result.h"
#include "collinea/block/block.h"

namespace collinea {

/// Finds images as people and other programs name them: by the path below the photo folder, or by the file name alone
/// where only one image has it; in any letter case where that names only one.
class ImageNames {
 public:
  explicit ImageNames(const Block& block);
  [[nodiscard]] std::optional<ImageId> find(const std::string& name) const;
  /// The image whose path below the photo folder is the end of `path` (the whole one, where a file is there), the
  /// longest of them; else as find() does. Errors: none, or several.
  [[nodiscard]] Result<ImageId> find_image(const std::filesystem::path& path) const;

 private:
  /// By path, path in lower case, name, name in lower case; nothing: several have it.
  std::array<std::map<std::string, std::optional<ImageId>>, 4> known_;
};

}  // namespace collinea
