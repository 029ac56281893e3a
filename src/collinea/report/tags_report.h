// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "collinea/feature/tags.h"

namespace collinea {

/// A tag of an image, and the point that is meant by it.
struct NamedTag {
  Tag tag;
  std::size_t image = 0;  ///< number of it in TagsReport::images
  std::string point;      ///< empty: it is no mark
};

/// Coded tags of images.
struct TagsReport {
  std::vector<std::filesystem::path> images;
  std::vector<NamedTag> tags;  ///< by image, then by family and number
  std::filesystem::path file;  ///< of the marks
};

/// A line a tag, and how many of them are marks.
[[nodiscard]] std::string tags_text(const TagsReport& report);

}  // namespace collinea
