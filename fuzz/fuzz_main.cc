// SPDX-License-Identifier: Apache-2.0
// The fuzzer of one target, named by the environment variable COLLINEA_FUZZ_TARGET; with COLLINEA_FUZZ_SEEDS it writes
// that target's seeds into the folder which that names, and ends. Called by tools/fuzz.sh.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "target.h"

namespace {

using collinea::fuzz::Target;

Target wanted() {
  const char* name = std::getenv("COLLINEA_FUZZ_TARGET");
  for (const Target& target : collinea::fuzz::all_targets())
    if (name && target.name == name) return target;
  std::fprintf(stderr, "COLLINEA_FUZZ_TARGET must be one of:\n");
  for (const Target& target : collinea::fuzz::all_targets()) std::fprintf(stderr, "%s\n", target.name.c_str());
  std::exit(2);
}

const Target& target() {
  static const Target one = wanted();
  return one;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  const Target& one = target();  // ends here where it is none
  const char* seeds = std::getenv("COLLINEA_FUZZ_SEEDS");
  if (!seeds) return 0;
  for (std::size_t i = 0; i < one.seeds.size(); ++i)
    std::ofstream(std::filesystem::path(seeds) / ("seed-" + std::to_string(i)), std::ios::binary) << one.seeds[i];
  std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)target().accepts({reinterpret_cast<const char*>(data), size});
  return 0;
}
