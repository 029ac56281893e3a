// SPDX-License-Identifier: Apache-2.0
#include "collinea/project/internal/project_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace collinea {

Result<std::shared_ptr<const ProjectLock>> ProjectLock::take(const std::filesystem::path& folder) {
  const int descriptor = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0)
    return fail(Errc::kBadInput, folder.string() + " cannot be opened: " + std::generic_category().message(errno));
  std::shared_ptr<const ProjectLock> lock(new ProjectLock(descriptor));
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
    return fail(Errc::kBadInput, "another collinea is at work on " + folder.string() + ": wait for it, or stop it");
  return lock;
}

ProjectLock::~ProjectLock() { ::close(descriptor_); }

}  // namespace collinea
