// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace collinea {

/// A small random stream (splitmix64) with the same numbers on every machine. Streams of work items that may run on any
/// thread derive from (seed, item), never from the thread.
class Random {
 public:
  explicit Random(std::uint64_t seed, std::uint64_t item = 0) : state_(seed * 0x9e3779b97f4a7c15u + item) {
    state_ = bits() ^ (item * 0xbf58476d1ce4e5b9u);
    bits();
  }

  std::uint64_t bits() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// Evenly spread in [0, 1).
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Evenly spread in [0, bound), bound >= 1.
  std::uint32_t below(std::uint32_t bound) {
    return static_cast<std::uint32_t>(((bits() >> 32) * std::uint64_t{bound}) >> 32);
  }
  /// Normal with mean 0 and standard deviation 1 (Box-Muller).
  double normal() {
    const double radius = std::sqrt(-2 * std::log(1 - uniform()));
    return radius * std::cos(2 * std::numbers::pi * uniform());
  }

 private:
  std::uint64_t state_;
};

}  // namespace collinea
