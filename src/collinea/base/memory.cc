// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace collinea {
namespace {

// Of the machine [bytes]; 0 where that cannot be known.
std::uint64_t physical_memory() {
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
  return pages > 0 && page_bytes > 0 ? std::uint64_t(pages) * std::uint64_t(page_bytes) : 0;
}

}  // namespace

std::uint64_t usable_memory() {
  constexpr std::uint64_t kNone = std::numeric_limits<std::uint64_t>::max();
  std::uint64_t least = kNone;
  if (const std::uint64_t all = physical_memory(); all > 0) least = all;
  rlimit space{};
  if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY)
    least = std::min(least, std::uint64_t(space.rlim_cur));
  // of control groups 2 and 1, as a container sees its own; "max" where there is no limit
  for (const char* file : {"/sys/fs/cgroup/memory.max", "/sys/fs/cgroup/memory/memory.limit_in_bytes"})
    if (std::uint64_t limit = 0; std::ifstream(file) >> limit && limit > 0) least = std::min(least, limit);
  return least == kNone ? 0 : least;
}

void give_large_memory_back() {
#ifdef __GLIBC__
  constexpr int kLarge = 1 << 18;  // [bytes]
  mallopt(M_MMAP_THRESHOLD, kLarge);
  mallopt(M_TRIM_THRESHOLD, 4 * kLarge);
#endif
}

void give_back_freed_memory() {
#ifdef __GLIBC__
  malloc_trim(0);
#endif
}

}  // namespace collinea
