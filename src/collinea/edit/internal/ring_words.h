// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "collinea/base/result.h"

namespace collinea {

inline constexpr std::size_t kMostRingPoints = 20'000;

/// The points of a ring, two words each. Errors: fewer than three, an odd count, too many, no numbers; `form` is that
/// of the command, `x` and `y` name the coordinates.
[[nodiscard]] Result<std::vector<Eigen::Vector2d>> ring_in(std::span<const std::string> words, std::string_view form,
                                                           std::string_view x, std::string_view y);
void append_words(const std::vector<Eigen::Vector2d>& ring, std::vector<std::string>& words);

/// Error: what the ring encloses is nothing; sides that cross are allowed (inside is behind an odd number of them).
[[nodiscard]] Result<> check_ring(const std::vector<Eigen::Vector2d>& ring);

}  // namespace collinea
