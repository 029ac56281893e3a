// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace collinea {

/// "1 image", "3 images": a count with its noun, which takes an s in the plural.
template <class Count>
[[nodiscard]] std::string counted(Count count, std::string_view noun) {
  return fmt::format("{} {}{}", count, noun, count == Count(1) ? "" : "s");
}

}  // namespace collinea
