// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/dense/depth_map.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/texture_centroid.h"
#include "collinea/geometry/rigid3.h"

namespace collinea::dense {

/// The overview of another image, placed by the one it is compared with.
struct LocatedMap {
  DepthMap map;
  Rigid3 reference_from_cam;
};

/// Inverse depths on which the overview `own` and those of the other images agree within `reach`, or, where none are so
/// close, within three times that: of leaves and grass no two images show the same. Of several surfaces
/// along a ray the nearest one that at least three images confirm, or two when one of them is `own`: what lies in
/// front hides the rest. What only two images have on their images is left out where its inverse depth differs by
/// more than half from that of what three see around it. NaN where no images agree.
[[nodiscard]] FloatImage agreed_surface(const DepthMap& own, const std::vector<LocatedMap>& others, float reach);

/// Leaves and grass look different from everywhere: windows do not correlate, though small images agree on the
/// surface. Where `result`, of the finest level, has nothing and the image has texture, and not only beside
/// (`centroid`), it gets the surface `agreed` upon, with a sigma from the size of its pixels and its roughness.
void fill_rough(const Level& finest, const TextureCentroid& centroid, const FloatImage& agreed, Refined& result);

}  // namespace collinea::dense
