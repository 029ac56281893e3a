// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>

#include "collinea/base/result.h"

namespace collinea {

/// One field of an options struct, told once; the command line, JSON, and the manual all read this.
/// T is bool, int, double, std::string or a std::optional of one (nothing = chosen from the data; the help says how).
template <class Owner, class T>
struct Field {
  std::string_view name;
  T Owner::*member;
  std::string_view unit;  ///< "px", "m", "deg", "1" ...
  std::string_view help;
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
};

namespace detail {
template <class T>
struct Inner {
  using type = T;
};
template <class T>
struct Inner<std::optional<T>> {
  using type = T;
};
}  // namespace detail

/// Checks every numeric field of `options` against its own description.
template <class Options>
[[nodiscard]] Result<> validate(const Options& options) {
  Result<> verdict;
  Options::describe([&](const auto& field) {
    const auto& value = options.*field.member;
    using T = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<typename detail::Inner<T>::type>) {
      std::optional<double> number;
      if constexpr (std::is_arithmetic_v<T>)
        number = static_cast<double>(value);
      else if (value)
        number = static_cast<double>(*value);
      if (verdict && number && !(*number >= field.min && *number <= field.max))
        verdict = fail(Errc::kBadInput, std::string(field.name) + " = " + std::to_string(*number) + " [" +
                                            std::string(field.unit) + "] is out of range");
    }
  });
  return verdict;
}

}  // namespace collinea
