// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <exception>

#include "collinea/app/commands.h"
#include "collinea/base/memory.h"

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
