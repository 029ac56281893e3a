// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <malloc.h>

#include <cstdio>
#include <exception>

#include "collinea/app/commands.h"

namespace {

// Rasters and pictures come and go by megabytes. By default the C library learns from the first that goes to keep the
// like of it in its heaps, where what is small and stays keeps much of what was large from going back to the system:
// an orthophoto of 400 pictures then holds half as much again as it uses. The price is a few per cent of system time.
void give_large_memory_back() {
#ifdef M_MMAP_THRESHOLD
  constexpr int kLarge = 1 << 20;  // [bytes]
  mallopt(M_MMAP_THRESHOLD, kLarge);
  mallopt(M_TRIM_THRESHOLD, 4 * kLarge);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  using namespace collinea;
  give_large_memory_back();
  try {
    return dispatch(argc, argv, all_commands());
  } catch (const std::exception& defect) {
    fmt::print(stderr, "collinea has a defect, please report it: {}\n", defect.what());
    return 1;
  }
}
