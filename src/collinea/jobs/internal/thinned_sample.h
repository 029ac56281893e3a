// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace collinea {

/// Of many values, which come in a fixed order, all up to four million, of more every second, every fourth ...: so many
/// that their quantiles are those of all, to some 1/2000 of the order.
class ThinnedSample {
 public:
  void add(double value) {
    if (count_++ % stride_ != 0) return;
    values_.push_back(value);
    if (values_.size() < kMost) return;
    for (std::size_t i = 0; 2 * i < values_.size(); ++i) values_[i] = values_[2 * i];
    values_.resize((values_.size() + 1) / 2);
    stride_ *= 2;
  }
  [[nodiscard]] const std::vector<double>& values() const { return values_; }

 private:
  static constexpr std::size_t kMost = std::size_t{1} << 22;
  std::vector<double> values_;
  std::uint64_t count_ = 0, stride_ = 1;
};

}  // namespace collinea
