// SPDX-License-Identifier: Apache-2.0
#include "collinea/app/commands.h"
#include "collinea/app/guarded.h"
#include "collinea/base/memory.h"

int main(int argc, char** argv) {
  using namespace collinea;
  give_large_memory_back();
  return guarded([&] { return dispatch(argc, argv, all_commands()); });
}
