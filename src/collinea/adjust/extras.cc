// SPDX-License-Identifier: Apache-2.0
#include <string>

#include "collinea/adjust/bundle.h"

namespace collinea {

std::string name_of_extra(const Block&, UnknownKind kind, std::uint32_t owner, int) {
  switch (kind) {
    case UnknownKind::kOrientation:
      return "the orientation of set-up " + std::to_string(owner + 1);
  }
  return "";
}

}  // namespace collinea
