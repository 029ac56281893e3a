// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/image_names.h"

#include <algorithm>

#include "collinea/io/text.h"

namespace collinea {
namespace {

// The path with / between folders, whichever the writer used.
std::string path_of(std::string text) {
  std::replace(text.begin(), text.end(), '\\', '/');
  return std::filesystem::path(text).lexically_normal().generic_string();
}

std::string name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

// What a name stands for, the strictest reading first.
std::array<std::string, 4> readings_of(const std::string& path) {
  return {path, lower(path), name_of(path), lower(name_of(path))};
}

}  // namespace

ImageNames::ImageNames(const Block& block) {
  for (const auto& [id, image] : block.images) {
    const auto readings = readings_of(path_of(image.file));
    for (std::size_t i = 0; i < readings.size(); ++i) {
      const auto [same, is_new] = known_[i].emplace(readings[i], id);
      if (!is_new) same->second.reset();
    }
  }
}

std::optional<ImageId> ImageNames::find(const std::string& name) const {
  const auto readings = readings_of(path_of(name));
  for (std::size_t i = 0; i < readings.size(); ++i)
    if (const auto found = known_[i].find(readings[i]); found != known_[i].end() && found->second) return found->second;
  return std::nullopt;
}

Result<ImageId> ImageNames::find_image(const std::filesystem::path& path) const {
  std::error_code ignored;
  const std::string whole =
      path_of(std::filesystem::exists(path, ignored) ? std::filesystem::absolute(path).string() : path.string());
  for (std::size_t at = 0; at != std::string::npos; at = whole.find('/', at)) {
    if (at > 0 || whole.starts_with('/')) ++at;
    if (const auto found = known_[0].find(whole.substr(at)); found != known_[0].end() && found->second)
      return *found->second;
  }
  if (const auto found = find(whole)) return *found;
  const std::string name = name_of(whole);
  if (known_[3].contains(lower(name)))
    return fail(Errc::kNotFound,
                "several photographs of the orientation are called " + name + ": give its path below the photo folder");
  return fail(Errc::kNotFound, "no photograph of the orientation is called " + name);
}

}  // namespace collinea
