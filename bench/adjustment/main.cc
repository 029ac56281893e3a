// SPDX-License-Identifier: Apache-2.0
// What the adjustment says of itself, held against simulated truth: the table that README.md beside it shows.
//
// usage: collinea_bench_adjustment [--quick] [--threads N] [--blocks N] [--only WORD]
// --quick: a tenth of the blocks and of the large block. --only: truth, inverse, free, blunders, components, speed.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>

#include "rows.h"

int main(int argc, char** argv) {
  using namespace collinea::bench;
  Effort effort;
  collinea::Run run;
  run.threads = 2;
  std::string only;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--quick") effort = {20, 6, 100, 20000};
    if (i + 1 == argc) break;
    if (word == "--threads") run.threads = std::max(1, std::atoi(argv[i + 1]));
    if (word == "--only") only = argv[i + 1];
    if (word == "--blocks") effort.blocks = std::max(3, std::atoi(argv[i + 1]));
  }
  const std::pair<const char*, std::function<Rows()>> parts[] = {{"inverse", [&] { return dense_inverse(run); }},
                                                                 {"free", [&] { return free_network(run); }},
                                                                 {"truth", [&] { return true_errors(effort, run); }},
                                                                 {"components", [&] { return variance_components(effort, run); }},
                                                                 {"blunders", [&] { return blunders(effort, run); }},
                                                                 {"speed", [&] { return large_block(effort, run); }}};
  bool ok = true;
  fmt::print("| what | must show | measured | ok |\n|---|---|---|---|\n");
  for (const auto& [name, part] : parts) {
    if (!only.empty() && only != name) continue;
    for (const Row& row : part()) {
      fmt::print("| {} | {} | {} | {} |\n", row.what, row.must, row.measured, row.ok ? "yes" : "NO");
      ok = ok && row.ok;
    }
    std::fflush(stdout);
  }
  return ok ? 0 : 1;
}
