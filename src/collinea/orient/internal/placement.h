// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <set>
#include <vector>

#include "collinea/adjust/bundle.h"
#include "collinea/base/finding.h"
#include "collinea/block/gauge.h"
#include "collinea/orient/given.h"
#include "collinea/orient/internal/reconstruction.h"

namespace collinea {

/// The datum of a block: the frame it lies in, by what, and which observations can take part there.
struct Placement {
  AdjustScope scope;
  Gauge gauge;
  bool georeferenced = false;               ///< the frame is the world
  bool metric = false;                      ///< lengths are in metres, by distances
  bool relative_heights = false;            ///< georeferenced in plan, but nothing observes a height
  std::set<ControlId> in_datum;             ///< control that fixed the similarity to the world
  std::set<ControlId> excluded_control;     ///< see reject_wrong_control()
  std::set<std::size_t> excluded_geodetic;  ///< indices in Block::geodetic: what contradicts the others, or the block
  std::vector<Finding> findings;
};

/// Rejects wrong control and brings the part into the frame that is best known, the first of
///   - its own, if its poses were given and nothing here knows better: no positions and no control, or they agree
///   - that of control, or of positions (with control, where there is some)
///   - that of positions on one line, with attitudes, see strip_datum()
///   - that of positions without heights or close together, with what is level in the images, see level_datum()
///   - a local one: that of the given poses, or z up as images are held; scaled by distances, where there are some
/// What was measured on the ground and cannot be where the block lies then is rejected, too, see gross_geodetic().
/// `given`: may be null. What was rejected leaves the setup of the part, too.
[[nodiscard]] Placement set_datum(Reconstruction& part, const GivenOrientation* given, const OrientOptions& options,
                                  std::uint64_t seed);

}  // namespace collinea
