// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/io/las.h"

namespace collinea {

/// Hands `take(std::vector<CloudPoint>&) -> Result<>` the points of a LAS file piece by piece, until it fails. Errors:
/// of the file and of `take`, stopped.
template <class Take>
[[nodiscard]] Result<> for_each_piece(const std::filesystem::path& cloud, const Run& run, const Take& take) {
  constexpr std::size_t kPiece = 100'000;  // points: a few MB
  COLLINEA_TRY(LasReader reader, LasReader::open(cloud));
  for (;;) {
    COLLINEA_TRY(std::vector<CloudPoint> points, reader.read(kPiece));
    if (points.empty()) return {};
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    if (Result<> taken = take(points); !taken) return taken;
  }
}

}  // namespace collinea
