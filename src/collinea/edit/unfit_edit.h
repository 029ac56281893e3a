// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "collinea/base/result.h"

namespace collinea {

/// An edit in force that does not fit what was imported: its image or its point is gone.
struct UnfitEdit {
  std::uint64_t number = 0;
  std::string point;    ///< its name; empty: it is about something else
  std::string command;  ///< as one line
  Error why;
};

}  // namespace collinea
