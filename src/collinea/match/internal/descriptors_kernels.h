// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

namespace collinea {

/// The nearest and the second nearest of a set of descriptors, by squared Euclidean distance. Of equally near ones the
/// first in order is `index`; `second` then equals `best`.
struct NearestTwo {
  static constexpr std::int32_t kNone = std::numeric_limits<std::int32_t>::max();

  std::uint32_t index = 0;
  std::int32_t best = kNone;    ///< kNone: the set is empty
  std::int32_t second = kNone;  ///< kNone: the set has less than two
  friend bool operator==(const NearestTwo&, const NearestTwo&) = default;
};

/// For every descriptor of a the nearest two of b, and for every descriptor of b the nearest two of a. Exact for all
/// bytes. Descriptors are 128 bytes each, one after the other; of_a and of_b hold count_a and count_b entries.
/// Every pair is computed once; the working memory grows with count_a + count_b, not with their product.
void nearest_two(const std::uint8_t* a, std::size_t count_a, const std::uint8_t* b, std::size_t count_b,
                 NearestTwo* of_a, NearestTwo* of_b);

/// distances[k] = squared Euclidean distance of `one` from the descriptor which[k] of `all`, for k in [0, count). Exact
/// for all bytes.
void squared_distances(const std::uint8_t* one, const std::uint8_t* all, const std::uint32_t* which, std::size_t count,
                       std::int32_t* distances);

/// products[k] = one . (all + k length), for k in [0, count): dot products of vectors of signed bytes, one after the
/// other in `all`. length is a multiple of 128, at most 2^17. Exact for bytes of -127 to 127.
void dot_products(const std::int8_t* one, const std::int8_t* all, std::size_t length, std::size_t count,
                  std::int32_t* products);

}  // namespace collinea
