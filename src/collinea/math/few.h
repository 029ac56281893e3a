// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>

namespace collinea {

/// Up to N values in place, without a heap: the answers of a minimal solver.
template <class T, int N>
struct Few {
  static constexpr int kCapacity = N;

  std::array<T, N> items;
  int count = 0;

  void add(const T& item) { items[static_cast<std::size_t>(count++)] = item; }
  [[nodiscard]] int size() const { return count; }
  [[nodiscard]] bool empty() const { return count == 0; }
  [[nodiscard]] const T& operator[](int i) const { return items[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const T* begin() const { return items.data(); }
  [[nodiscard]] const T* end() const { return items.data() + count; }
};

}  // namespace collinea
