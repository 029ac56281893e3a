// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "collinea/base/result.h"

namespace collinea {

/// What went wrong, with the options that it is about: "give a CRS (option --crs)". Without a spelling they have their
/// names.
[[nodiscard]] inline std::string text_of(const Error& error, const SpellOption& spelling) {
  std::string names;
  for (const OptionName& option : error.options)
    names += (names.empty() ? "" : ", ") + (spelling ? spelling(option) : option.name);
  if (names.empty()) return error.message;
  return error.message + (error.options.size() == 1 ? " (option " : " (options ") + names + ")";
}

}  // namespace collinea
