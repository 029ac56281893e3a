// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace collinea {

/// A project that is served.
struct ServedProject {
  std::string id;    ///< the same for a folder whenever it is served
  std::string name;  ///< of its folder
  std::filesystem::path folder;
};

/// The projects among these folders, and among the folders in them; each once, in the order of their paths. Looked for
/// anew at every call.
[[nodiscard]] std::vector<ServedProject> find_projects(std::span<const std::filesystem::path> roots);
/// The one with this id; nothing when there is none.
[[nodiscard]] std::optional<ServedProject> find_project(std::span<const std::filesystem::path> roots,
                                                        std::string_view id);

/// A regular file, open to be read by parts.
class OpenFile {
 public:
  /// The file of a project at parts of a path below its folder: what steps left in products, report, adjustment and
  /// depth. Nothing when there is none, when it is no regular file, and when it lies outside that folder, wherever
  /// symbolic links lead.
  static std::shared_ptr<const OpenFile> in_project(const std::filesystem::path& folder,
                                                    std::span<const std::string> parts);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// Changes when the file does: in quotation marks, as `ETag` has it.
  [[nodiscard]] const std::string& tag() const { return tag_; }
  /// Reads from a position on; the number of bytes, 0 at the end or when they cannot be read. From any thread.
  [[nodiscard]] std::size_t read_at(std::uint64_t offset, std::span<char> into) const;

  OpenFile(const OpenFile&) = delete;
  OpenFile& operator=(const OpenFile&) = delete;
  ~OpenFile();

 private:
  explicit OpenFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
  std::uint64_t size_ = 0;
  std::string tag_;
};

/// A product or page that a project holds.
struct ProjectFile {
  std::string path;  ///< below the folder
  std::uint64_t bytes = 0;
};
/// What can be downloaded of a project, in the order of the paths; depth maps are left out, of which there is one an
/// image.
[[nodiscard]] std::vector<ProjectFile> files_of(const std::filesystem::path& folder);

/// By the ending of its name: "image/tiff".
[[nodiscard]] std::string_view content_type_of(const std::filesystem::path& file);

}  // namespace collinea
