// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/settings_paths.h"

#include <filesystem>

namespace collinea {
namespace {

std::filesystem::path made_absolute(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::absolute(path, error).lexically_normal();
}

void make_absolute(PathKind, std::filesystem::path& path) { path = made_absolute(path); }

void make_absolute(PathKind kind, std::string& text) {
  std::error_code error;
  if (kind == PathKind::kFileOrWord && std::filesystem::is_regular_file(text, error))
    text = made_absolute(text).string();
}

template <class Enum, class... Other>
void make_absolute(PathKind kind, WordOr<Enum, Other...>& value) {
  std::string text = value.text();
  make_absolute(kind, text);
  value = text;
}

}  // namespace

void make_paths_absolute(Settings& settings) {
  Settings::each(settings, [](const char*, const char*, auto& options) {
    for_each_field(options, [](const auto& field, auto& owner) {
      auto& value = owner.*field.member;
      if constexpr (requires { make_absolute(field.path, value); })
        make_absolute(field.path, value);
      else if constexpr (requires { make_absolute(field.path, *value); })
        if (value) make_absolute(field.path, *value);
    });
  });
}

}  // namespace collinea
