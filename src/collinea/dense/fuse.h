// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>

#include "collinea/base/run.h"
#include "collinea/dense/depth_map.h"
#include "collinea/dense/internal/fused_point.h"
#include "collinea/dense/internal/neighbours.h"

namespace collinea {

/// The colours of an image as it was taken, at 1/shrink of its size as in PixelSource.
using ColourSource = std::function<Result<ColourImage>(ImageId image, int shrink)>;
using PointSink = std::function<Result<>(std::span<const FusedPoint> points)>;

struct FuseReport {
  std::int64_t points = 0;
  std::map<ImageId, double> confirmed;  ///< part of the measured pixels of each depth map that others confirm
};

/// One cloud from the depth maps of `images`, written to `sink` in batches, in an order that depends on nothing but the
/// input. A pixel becomes a point when at least options.min_images maps (itself included; or all that look at it, but
/// two) agree within max_sigmas and max_reprojection_px (or two sigmas, where that is more) and know it to max_sigma_px
/// of parallax; where they do not, min_images, or all that have it on their image. Fewer, and by 1 / sigma^2 none
/// weightier, look through it. The point is the weighted mean along its ray. Pixels of
/// other maps that show a point already written are not written again. Memory: options.memory_mb of depth maps, the
/// points of a few strips of an image and a bit per pixel of the images that overlap those already written and are
/// still to come. When the maps that overlap one do not fit, the log says so. `colours` may be empty: points stay
/// black. Errors: kCancelled, and what store, colours and sink say.
[[nodiscard]] Result<FuseReport> fuse(const Block& block, const TieView& ties, std::span<const ImageId> images,
                                      DepthStore& store, const ColourSource& colours, const PointSink& sink,
                                      const DenseOptions& options, const Run& run);

}  // namespace collinea
