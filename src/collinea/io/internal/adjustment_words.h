// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <numbers>
#include <string>
#include <string_view>

#include "collinea/block/geodetic.h"

namespace collinea {

// What writer and reader of adjustment files share.

inline constexpr std::string_view kAdjustmentTitle = "collinea-adjustment";
inline constexpr double kDegree = std::numbers::pi / 180;

/// A kind of measurement on the ground as one word.
[[nodiscard]] inline std::string geodetic_word(std::size_t kind) {
  std::string word = kGeodeticKindNames[kind];
  std::replace(word.begin(), word.end(), ' ', '_');
  return word;
}

}  // namespace collinea
