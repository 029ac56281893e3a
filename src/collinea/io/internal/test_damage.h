// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "collinea/math/random.h"

namespace collinea {

/// Hands `read` a text cut off at every `step`-th byte, then `trials` times with some bytes of chance, a piece of
/// it that comes again or is left out, or a number that is none of this world. The reader may refuse; it must come
/// back.
template <class Read>
void read_damaged(std::string_view text, Read&& read, int trials = 2000, std::size_t step = 1) {
  for (std::size_t end = 0; end < text.size(); end += step) read(std::string(text.substr(0, end)));
  constexpr std::string_view kOdd[] = {"1e308", "-1e308", "nan", "inf",     "-1", "0", "99999999999999999999",
                                       "",      ",,,,",   "\"",  "\xff\xfe"};
  for (int trial = 0; trial < trials; ++trial) {
    Random random(3, std::uint64_t(trial));
    std::string broken(text);
    const auto somewhere = [&] { return std::size_t{random.below(std::uint32_t(broken.size()))}; };
    switch (trial % 4) {
      case 0:
      case 1:
        for (int k = 0; k < 1 + trial / 4 % 4; ++k) broken[somewhere()] = char(random.bits());
        break;
      case 2: {  // a piece of it comes again, or is left out
        const std::size_t from = somewhere(), count = somewhere() / 4;
        if (random.below(2) == 0)
          broken.insert(somewhere(), broken.substr(from, count));
        else
          broken.erase(from, count);
        break;
      }
      default: {  // something else between two separators
        const std::size_t from = broken.find_first_of(" ,\t\n", somewhere());
        if (from == std::string::npos) break;
        const std::size_t end = std::min(broken.find_first_of(" ,\t\n", from + 1), broken.size());
        broken.replace(from + 1, end - from - 1, kOdd[random.below(std::uint32_t(std::size(kOdd)))]);
      }
    }
    if (!broken.empty()) read(broken);
  }
}

}  // namespace collinea
