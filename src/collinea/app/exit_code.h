// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/result.h"

namespace collinea {

/// The exit code of `verify` where files are not those that were signed.
inline constexpr int kFilesDiffer = 8;

/// The exit code of the program for each kind of failure; 0 is success and 1 a defect in collinea itself.
[[nodiscard]] constexpr int exit_code(Errc code) {
  switch (code) {
    case Errc::kBadInput:
      return 2;
    case Errc::kNotFound:
      return 3;
    case Errc::kBadFormat:
      return 4;
    case Errc::kUnsupported:
      return 5;
    case Errc::kIllPosed:
      return 6;
    case Errc::kNotConverged:
      return 7;
    case Errc::kCancelled:
      return 130;
  }
  return 1;
}

}  // namespace collinea
