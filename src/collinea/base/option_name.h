// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <functional>
#include <string>

namespace collinea {

/// An option of the program, by its field in the description of its options struct (base/options.h): "crs". Errors and
/// findings name options so; faces spell them as their users type them (--crs), and no module below them does.
struct OptionName {
  std::string name;        ///< of the field
  std::string group = {};  ///< of the options it belongs to, where another has the same name; empty: whichever has it
  std::string value = {};  ///< the one to choose; empty: the user's

  friend bool operator==(const OptionName&, const OptionName&) = default;

  template <class Visit>
  static void fields(Visit&& visit) {
    using R = OptionName;
    visit("name", &R::name);
    visit("group", &R::group);
    visit("value", &R::value);
  }
};

/// "crs"_option.
[[nodiscard]] inline OptionName operator""_option(const char* name, std::size_t size) {
  return {std::string(name, size)};
}

/// How a face spells an option, with its value where there is one: the command line as "--calibration none".
using SpellOption = std::function<std::string(const OptionName&)>;

}  // namespace collinea
