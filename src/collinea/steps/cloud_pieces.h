// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/cloud/las.h"

namespace collinea {

/// Points of a cloud that are in memory together: a few megabytes.
constexpr std::size_t kPiecePoints = 65'536;

/// Hands `take(std::vector<CloudPoint>&) -> Result<>` the points of a LAS file piece by piece, until it fails. Errors:
/// of the file and of `take`, stopped.
template <class Take>
[[nodiscard]] Result<> for_each_piece(const std::filesystem::path& cloud, const Run& run, const Take& take) {
  COLLINEA_TRY(LasReader reader, LasReader::open(cloud));
  for (;;) {
    COLLINEA_TRY(std::vector<CloudPoint> points, reader.read(kPiecePoints));
    if (points.empty()) return {};
    if (run.stopped()) return fail(Errc::kCancelled, "stopped");
    if (Result<> taken = take(points); !taken) return taken;
  }
}

}  // namespace collinea
