// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include "collinea/adjust/bundle.h"
#include "collinea/block/block.h"
#include "collinea/block/gauge.h"
#include "collinea/geometry/similarity3.h"

namespace collinea {

/// The datum of a block whose positions determine location, scale and north, but not what is level: they have no
/// heights, or reach too little for their errors. Level comes from the images.
struct LevelDatum {
  Similarity3 world_from_block;
  std::map<ImageId, GivenVertical> verticals;  ///< observations that keep it level in the adjustment
  LevelSource level_by = LevelSource::kNone;   ///< what level comes from
  double level_sigma_rad = 0;
  double rotation_sigma_rad = 0;  ///< of north, and of the scale as a part of it: by the sigmas of the positions
  std::size_t positions = 0, heights = 0;
};

/// Level is, of several directions, the one under which the positions in plan fit best: by the attitudes the camera
/// wrote; that which is most square to the horizontal axes of the images, as images are held; against the mean
/// view, as from the air; against the mean lower edge. Then scale, north and location by the positions in plan (least
/// squares, outliers left out), height by the median where there are heights. Nothing when fewer than three images have
/// positions, when their stations are on one line (within the positions' uncertainty), or when the scale would not be
/// known to a half.
[[nodiscard]] std::optional<LevelDatum> level_datum(const Block& block);

}  // namespace collinea
