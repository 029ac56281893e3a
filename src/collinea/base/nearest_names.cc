// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/nearest_names.h"

#include <algorithm>
#include <cctype>
#include <utility>

#include "collinea/base/words.h"

namespace collinea {
namespace {

char small(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// In halves of a character; 0: the same.
std::size_t cost_of(char a, char b) { return a == b ? 0 : small(a) == small(b) ? 1 : 2; }

// Optimal string alignment, in halves of a character.
std::size_t distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), last(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = 2 * j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = 2 * i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 2, row[j - 1] + 2, last[j - 1] + cost_of(a[i - 1], b[j - 1])});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 2);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last[b.size()];
}

}  // namespace

std::vector<std::string> nearest_names(std::string_view name, const std::vector<std::string>& names, std::size_t most) {
  const std::size_t limit = std::max<std::size_t>(4, 2 * name.size() / 3);
  std::vector<std::pair<std::size_t, std::size_t>> near;  // distance, index
  for (std::size_t i = 0; i < names.size(); ++i) {
    const std::size_t longer = std::max(names[i].size(), name.size()), shorter = std::min(names[i].size(), name.size());
    if (2 * (longer - shorter) > limit) continue;
    if (const std::size_t d = distance(name, names[i]); d <= limit && d < 2 * longer) near.emplace_back(d, i);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::string> out;
  for (std::size_t i = 0; i < std::min(most, near.size()); ++i) out.push_back(names[near[i].second]);
  return out;
}

Error with_nearest(Error error, std::string_view name, const std::vector<std::string>& names) {
  const std::vector<std::string> near = nearest_names(name, names);
  if (near.empty()) return error;
  const std::string listing = listed(std::vector<std::string_view>(near.begin(), near.end()));
  return std::move(error).advising("; did you mean " + listing + "?");
}

}  // namespace collinea
