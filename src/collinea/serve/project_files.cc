// SPDX-License-Identifier: Apache-2.0
#include "collinea/serve/project_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>

#include "collinea/base/hash.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFolders[] = {"adjustment", "products", "report"};  // what is listed

bool is_project(const fs::path& folder) {
  std::error_code error;
  return fs::is_regular_file(folder / "project.json", error);
}

void add_project(const fs::path& folder, std::vector<ServedProject>& projects) {
  std::error_code error;
  const fs::path canonical = fs::canonical(folder, error);
  if (error || !is_project(canonical)) return;
  const std::string id = Hash().add(canonical.native()).hex();
  const bool known = std::any_of(projects.begin(), projects.end(), [&](const auto& other) { return other.id == id; });
  if (!known) projects.push_back({id, canonical.filename().string(), canonical});
}

bool is_beneath(const fs::path& path, const fs::path& folder) {
  const std::string inside = folder.native() + "/";
  return path.native().size() > inside.size() && path.native().starts_with(inside);
}

// Where an open file lies now, whatever became of the names that led to it. Empty: not known.
fs::path path_of(int descriptor) {
  std::error_code error;
  fs::path path = fs::read_symlink(fmt::format("/proc/self/fd/{}", descriptor), error);
  return error ? fs::path() : path;
}

bool is_plain_name(const std::string& part) {
  return !part.empty() && part != "." && part != ".." && part.find('/') == std::string::npos &&
         part.find('\0') == std::string::npos;
}

}  // namespace

std::vector<ServedProject> find_projects(std::span<const fs::path> roots) {
  std::vector<ServedProject> projects;
  for (const fs::path& root : roots) {
    add_project(root, projects);
    std::error_code error;
    std::vector<fs::path> inside;
    for (fs::directory_iterator entry(root, error), end; !error && entry != end; entry.increment(error))
      inside.push_back(entry->path());
    std::sort(inside.begin(), inside.end());
    for (const fs::path& folder : inside) add_project(folder, projects);
  }
  return projects;
}

std::optional<ServedProject> find_project(std::span<const fs::path> roots, std::string_view id) {
  for (ServedProject& project : find_projects(roots))
    if (project.id == id) return std::move(project);
  return std::nullopt;
}

std::shared_ptr<const OpenFile> OpenFile::in_project(const fs::path& folder, std::span<const std::string> parts) {
  if (parts.size() < 2 || !std::all_of(parts.begin(), parts.end(), is_plain_name)) return nullptr;
  if (parts[0] != "depth" && std::find(std::begin(kFolders), std::end(kFolders), parts[0]) == std::end(kFolders))
    return nullptr;
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (error) return nullptr;
  fs::path path = root;
  for (const std::string& part : parts) path /= part;
  path = fs::canonical(path, error);
  const fs::path top = root / parts[0];
  if (error || !is_beneath(path, top)) return nullptr;
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY);
  if (descriptor < 0) return nullptr;
  std::shared_ptr<OpenFile> file(new OpenFile(descriptor));
  struct stat about {};
  if (::fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode)) return nullptr;
  // A folder may have become a link since: what counts is where the file lies that was opened.
  if (!is_beneath(path_of(descriptor), top)) return nullptr;
  file->size_ = static_cast<std::uint64_t>(about.st_size);
  file->tag_ =
      fmt::format("\"{:x}-{:x}-{:x}-{:x}\"", about.st_ino, about.st_size, about.st_mtim.tv_sec, about.st_mtim.tv_nsec);
  return file;
}

std::size_t OpenFile::read_at(std::uint64_t offset, std::span<char> into) const {
  ssize_t count = 0;
  do count = ::pread(descriptor_, into.data(), into.size(), static_cast<off_t>(offset));
  while (count < 0 && errno == EINTR);
  return count > 0 ? static_cast<std::size_t>(count) : 0;
}

OpenFile::~OpenFile() { ::close(descriptor_); }

std::vector<ProjectFile> files_of(const fs::path& folder) {
  std::vector<ProjectFile> files;
  std::error_code error;
  const fs::path root = fs::canonical(folder, error);
  if (error) return files;
  for (const std::string_view name : kFolders) {
    const fs::path top = root / name;
    for (fs::recursive_directory_iterator entry(top, error), end; !error && entry != end; entry.increment(error)) {
      std::error_code failed;
      const bool is_file = entry->is_regular_file(failed) && is_beneath(fs::canonical(entry->path(), failed), top);
      const auto bytes = is_file ? entry->file_size(failed) : 0;
      if (is_file && !failed) files.push_back({entry->path().lexically_relative(root).generic_string(), bytes});
    }
  }
  std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.path < b.path; });
  return files;
}

std::string_view content_type_of(const fs::path& file) {
  const std::string ending = file.extension().string();
  constexpr std::pair<std::string_view, std::string_view> kTypes[] = {{".html", "text/html; charset=utf-8"},
                                                                      {".json", "application/json"},
                                                                      {".txt", "text/plain; charset=utf-8"},
                                                                      {".csv", "text/csv; charset=utf-8"},
                                                                      {".tif", "image/tiff"},
                                                                      {".png", "image/png"},
                                                                      {".jpg", "image/jpeg"},
                                                                      {".svg", "image/svg+xml"},
                                                                      {".dxf", "image/vnd.dxf"},
                                                                      {".gpkg", "application/geopackage+sqlite3"}};
  for (const auto& [known, type] : kTypes)
    if (known == ending) return type;
  return "application/octet-stream";
}

}  // namespace collinea
