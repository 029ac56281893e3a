// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>

#include "collinea/base/result.h"

namespace collinea {

/// Keeps a second program from working on the same project. Let go at the end of its life, or of the program's, however
/// that ends.
class ProjectLock {
 public:
  /// Errors: another program holds the lock; the folder cannot be opened. File systems without locks give one that
  /// keeps nobody out.
  static Result<std::shared_ptr<const ProjectLock>> take(const std::filesystem::path& folder);

  ProjectLock(const ProjectLock&) = delete;
  ProjectLock& operator=(const ProjectLock&) = delete;
  ~ProjectLock();

 private:
  explicit ProjectLock(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace collinea
