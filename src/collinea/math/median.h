// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <type_traits>

namespace collinea {

/// The median, the upper one of an even number. The values are not empty; afterwards they have another order.
template <class Values>
[[nodiscard]] typename std::remove_cvref_t<Values>::value_type median(Values&& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The value that `part` of them, in [0, 1], lie below, the nearest there is: 0 the smallest, 1 the largest. The values
/// are not empty; afterwards they have another order.
template <class Values>
[[nodiscard]] typename std::remove_cvref_t<Values>::value_type quantile(Values&& values, double part) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(part * double(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace collinea
