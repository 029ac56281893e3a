// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "collinea/cloud/las.h"
#include "collinea/edit/read_work.h"
#include "collinea/steps/cloud_pieces.h"

namespace collinea {

/// The points of a project's cloud that people left as a surface: those that edits by hand removed, or called noise,
/// are not among them. Classes are those of the edits alone: what the file holds is of an earlier terrain.
class LeftPoints {
 public:
  /// Errors: no cloud, not readable; the journal.
  [[nodiscard]] static Result<LeftPoints> open(const Project& project) {
    COLLINEA_TRY(LasReader reader, LasReader::open(project.cloud()));
    COLLINEA_TRY(std::vector<CloudRegion> regions, read_cloud_regions(project));
    return LeftPoints(std::move(reader), CloudEdits(regions_of_surface(std::move(regions))));
  }

  /// Before any was removed.
  [[nodiscard]] std::uint64_t points_in_file() const { return reader_.header().points; }

  /// The next piece; empty at the end.
  Result<std::vector<CloudPoint>> next() {
    for (;;) {
      COLLINEA_TRY(std::vector<CloudPoint> points, reader_.read(kPiecePoints));
      if (points.empty()) return points;
      for (CloudPoint& point : points) point.classification = kUnclassified;
      edits_.apply(points);
      std::erase_if(points, [](const CloudPoint& point) { return is_noise(point.classification); });
      if (!points.empty()) return points;
    }
  }

 private:
  LeftPoints(LasReader reader, CloudEdits edits) : reader_(std::move(reader)), edits_(std::move(edits)) {}
  LasReader reader_;
  CloudEdits edits_;
};

}  // namespace collinea
