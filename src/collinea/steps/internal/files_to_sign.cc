// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/files_to_sign.h"

#include <algorithm>
#include <tuple>

namespace collinea {
namespace {

namespace fs = std::filesystem;

void add_given(const fs::path& path, std::vector<SignedFile>& files) {
  std::error_code none;
  if (fs::is_regular_file(path, none))
    files.push_back({FileRole::kGiven, path.filename().string(), fs::absolute(path, none).parent_path()});
  if (!fs::is_directory(path, none)) return;
  for (const auto& entry : fs::directory_iterator(path, none))
    if (entry.is_regular_file(none)) add_given(entry.path(), files);
}

// The path that a value of an option is, or may be; empty: none.
template <class T>
fs::path path_in(const T& value) {
  if constexpr (requires { value.has_value(); })
    return value ? path_in(*value) : fs::path();
  else if constexpr (std::is_same_v<T, fs::path> || std::is_same_v<T, std::string>)
    return value;
  else if constexpr (requires { value.text(); })
    return value.text();
  else
    return {};
}

void add_all_given(const Settings& settings, std::vector<SignedFile>& files) {
  Settings::each(settings, [&](const char*, const char*, const auto& options) {
    for_each_field(options, [&](const auto& field, const auto& owner) {
      if (field.path == PathKind::kNone || field.path == PathKind::kOutput) return;
      if (const fs::path path = path_in(owner.*field.member); !path.empty()) add_given(path, files);
    });
  });
}

void add_below(const Project& project, const char* folder, FileRole role, std::vector<SignedFile>& files) {
  std::error_code none;
  for (const auto& entry : fs::recursive_directory_iterator(project.folder / folder, none))
    if (entry.is_regular_file(none))
      files.push_back({role, entry.path().lexically_relative(project.folder).generic_string(), {}});
}

}  // namespace

std::vector<SignedFile> files_to_sign(const Project& project, const Block& block) {
  std::vector<SignedFile> files;
  std::error_code error;
  const fs::path photos = fs::absolute(project.settings.photos, error);
  for (const auto& [id, image] : block.images) files.push_back({FileRole::kImage, image.file, photos});
  add_all_given(project.settings, files);
  add_below(project, "products", FileRole::kProduct, files);
  add_below(project, "adjustment", FileRole::kReport, files);
  const auto key = [](const SignedFile& file) { return std::tie(file.role, file.name, file.folder); };
  std::sort(files.begin(), files.end(), [&](const auto& a, const auto& b) { return key(a) < key(b); });
  files.erase(std::unique(files.begin(), files.end(), [&](const auto& a, const auto& b) { return key(a) == key(b); }),
              files.end());
  return files;
}

}  // namespace collinea
