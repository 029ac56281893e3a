// SPDX-License-Identifier: Apache-2.0
// What the adjustment says of itself, held against simulated truth, published results and real blocks: the table that
// README.md beside it describes.
//
// usage: collinea_bench_adjustment [--quick] [--threads N] [--blocks N] [--only PART]
// --quick: a tenth of the blocks and of the large block.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "rows.h"

namespace {

std::optional<int> positive(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() && value > 0 ? std::optional(value) : std::nullopt;
}

int refuse(const std::string& why) {
  fmt::print(stderr, "{}\n", why);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace collinea::bench;
  Effort effort;
  collinea::Run run;
  run.threads = 2;
  std::string only;
  std::optional<int> blocks;  // as asked for, before or after --quick
  // Programs that print rows stand in the source tree, and run the program that was built beside this one.
  const auto script = [&](const char* name) {
    return rows_of(fmt::format("python3 '{}/{}' --rows --collinea '{}/collinea'", COLLINEA_BENCH_FOLDER, name,
                               std::filesystem::path(argv[0]).parent_path().string()));
  };
  const std::vector<std::pair<std::string, std::function<Rows()>>> parts = {
      {"published", [&] { return script("published_adjustments.py"); }},
      {"truth", [&] { return true_errors(effort, run); }},
      {"inverse", [&] { return dense_inverse(run); }},
      {"gross_errors", [&] { return gross_errors(effort, run); }},
      {"survey", [&] { return survey_gross_errors(effort, run); }},
      {"components", [&] { return variance_components(effort, run); }},
      {"instruments", [&] { return instruments(effort, run); }},
      {"weak", [&] { return weak_blocks(run); }},
      {"free", [&] { return free_network(run); }},
      {"real", [&] { return script("adjustment/real_blocks.py"); }},
      {"speed", [&] { return large_block(effort, run); }}};
  const std::vector<std::string_view> words(argv + 1, argv + argc);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string word(words[i]);
    if (word == "--quick") {
      effort = {.blocks = blocks.value_or(180), .gross_error_blocks = 4, .large_images = 100, .large_points = 20000};
      continue;
    }
    if (word != "--threads" && word != "--blocks" && word != "--only") return refuse(word + ": no such option");
    if (++i == words.size()) return refuse(word + " needs a value");
    if (word == "--only") {
      only = words[i];
      continue;
    }
    const auto value = positive(words[i]);
    if (!value) return refuse(word + " needs a number from 1 on");
    if (word == "--threads")
      run.threads = *value;
    else
      effort.blocks = *(blocks = value);
  }
  if (!only.empty() && std::none_of(parts.begin(), parts.end(), [&](const auto& part) { return part.first == only; })) {
    std::string known;
    for (const auto& [name, part] : parts) known += (known.empty() ? "" : ", ") + name;
    return refuse("--only " + only + ": no such part; there are " + known);
  }
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
