// SPDX-License-Identifier: Apache-2.0
#include "collinea/pipeline/image_names.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

namespace collinea {
namespace {

// The path in lower case with / between folders, whichever the writer used.
std::string path_of(std::string text) {
  std::replace(text.begin(), text.end(), '\\', '/');
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
  return std::filesystem::path(text).lexically_normal().generic_string();
}

std::string name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

}  // namespace

ImageNames::ImageNames(const Block& block) {
  for (const auto& [id, image] : block.images) {
    const std::string path = path_of(image.file);
    by_path_.emplace(path, id);
    const auto [same, is_new] = by_name_.emplace(name_of(path), id);
    if (!is_new) same->second.reset();
  }
}

std::optional<ImageId> ImageNames::find(const std::string& name) const {
  const std::string path = path_of(name);
  if (const auto found = by_path_.find(path); found != by_path_.end()) return found->second;
  const auto found = by_name_.find(name_of(path));
  return found == by_name_.end() ? std::nullopt : found->second;
}

}  // namespace collinea
