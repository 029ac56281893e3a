// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "collinea/block/block.h"

namespace collinea {

/// Finds images as people and other programs name them: by the path below the photo folder, or by the file name alone
/// where only one image has it; in any letter case.
class ImageNames {
 public:
  explicit ImageNames(const Block& block);
  [[nodiscard]] std::optional<ImageId> find(const std::string& name) const;

 private:
  std::map<std::string, ImageId> by_path_;
  std::map<std::string, std::optional<ImageId>> by_name_;  ///< nothing: several have it
};

}  // namespace collinea
