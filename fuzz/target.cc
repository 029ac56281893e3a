// SPDX-License-Identifier: Apache-2.0
#include "target.h"

#include <fcntl.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "collinea/base/result.h"

namespace collinea::fuzz {
namespace {

struct ProcessFolder {
  std::filesystem::path path = std::filesystem::temp_directory_path() / ("collinea_fuzz_" + std::to_string(::getpid()));
  ProcessFolder() { std::filesystem::create_directories(path); }
  ~ProcessFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
};

}  // namespace

std::vector<Target> all_targets() {
  std::vector<Target> all;
  for (const auto& family : {table_targets(), adjustment_targets(), orientation_targets(), image_targets(),
                             cloud_targets(), project_targets()})
    all.insert(all.end(), family.begin(), family.end());
  return all;
}

const std::filesystem::path& folder() {
  static const ProcessFolder one;
  return one.path;
}

std::filesystem::path file_of(std::string_view bytes, const std::string& name) {
  const std::filesystem::path path = folder() / name;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  COLLINEA_CHECK(file >= 0 && ::write(file, bytes.data(), bytes.size()) == ::ssize_t(bytes.size()));
  ::close(file);
  return path;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string_view> parts_of(std::string_view bytes) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t cut = bytes.find(kCut);
    parts.push_back(bytes.substr(0, cut));
    if (cut == std::string_view::npos) return parts;
    bytes.remove_prefix(cut + kCut.size());
  }
}

}  // namespace collinea::fuzz
