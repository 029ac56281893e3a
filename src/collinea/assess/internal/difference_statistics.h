// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace collinea {

/// Statistics of a stream of differences. Mean, spread and shares are of all of them; median and nmad of every so
/// manieth, at most some 2 million of them.
class DifferenceStatistics {
 public:
  static constexpr std::array<double, 6> kMultiples = {1, 3, 4, 5, 6, 10};  ///< of the tolerance

  void add(double difference_m, double tolerance_m);

  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] double mean_m() const;
  [[nodiscard]] double standard_deviation_m() const;  ///< about the mean
  [[nodiscard]] double rms_m() const;                 ///< about zero
  [[nodiscard]] double median_m() const;
  [[nodiscard]] double nmad_m() const;  ///< 1.4826 times the median distance from the median
  [[nodiscard]] double lowest_m() const { return lowest_m_; }
  [[nodiscard]] double highest_m() const { return highest_m_; }
  /// The share whose absolute value is below kMultiples[i] times the tolerance.
  [[nodiscard]] double share_below(std::size_t i) const;

 private:
  std::size_t count_ = 0;
  double sum_m_ = 0, sum_squares_m2_ = 0, lowest_m_ = 0, highest_m_ = 0;
  std::array<std::size_t, kMultiples.size()> below_{};
  std::vector<float> kept_;
  std::size_t stride_ = 1;
};

}  // namespace collinea
