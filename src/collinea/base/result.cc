// SPDX-License-Identifier: Apache-2.0
#include "collinea/base/result.h"

#include <stdexcept>

namespace collinea {

void bug(std::string_view what, std::source_location at) {
  throw std::logic_error(std::string(at.file_name()) + ":" + std::to_string(at.line()) +
                         ": broken promise: " + std::string(what));
}

}  // namespace collinea
