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

}  // namespace collinea
