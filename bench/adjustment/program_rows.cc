// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "rows.h"

namespace collinea::bench {

// Lines "| what | must | measured | yes |".
Rows rows_of(const std::string& command) {
  Rows rows;
  std::string text;
  std::FILE* output = popen(command.c_str(), "r");
  if (!output) return {{command, "runs", "does not", false}};
  std::array<char, 4096> part{};
  while (std::fgets(part.data(), static_cast<int>(part.size()), output)) {
    text += part.data();
    if (text.back() != '\n') continue;
    std::vector<std::string> cells;
    for (std::size_t at = text.find("| "); at != std::string::npos;) {
      const std::size_t end = text.find(" |", at + 1);
      if (end == std::string::npos) break;
      cells.push_back(text.substr(at + 2, end > at + 2 ? end - at - 2 : 0));
      at = end + 1;
    }
    if (cells.size() == 4) rows.push_back({cells[0], cells[1], cells[2], cells[3] == "yes"});
    text.clear();
  }
  // It fails of itself when a row is not ok; otherwise it has died, and rows are missing.
  const bool failed = pclose(output) != 0;
  const bool all_ok = std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.ok; });
  if (rows.empty() || (failed && all_ok)) rows.push_back({command, "runs to its end", "does not", false});
  return rows;
}

}  // namespace collinea::bench
