// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "collinea/base/run.h"
#include "collinea/base/shared_budget.h"
#include "collinea/dense/depth_map.h"
#include "collinea/dense/internal/neighbours.h"
#include "collinea/dense/working_images.h"

namespace collinea {

/// Room for the costs of up to `at_once` images that are matched side by side: half of options.memory_mb, or what they
/// take where the ground is smooth, if that is more. Those of rough ground wait for one another.
[[nodiscard]] SharedBudget budget_for_costs(const DenseOptions& options, int at_once);

/// A first, coarse idea of the surface, from small images. Every pixel with a grey value has a depth, right or wrong:
/// only together the overviews of several images tell which. Errors as of depth_map.
[[nodiscard]] Result<DepthMap> overview(const Block& block, ImageId image, const TieView& ties, WorkingImages& images,
                                        SharedBudget& costs, const DenseOptions& options, const Run& run);

/// The depth of every pixel of one oriented image, measured against its neighbours: coarse to fine, at each level a
/// sweep along the rays of the image around the surface of the level above, with semi-global regularisation; at the
/// last one correlation to a fraction of a pixel. It starts from what the `overviews` of the image and of those around
/// it agree on (those missing are left out), or, when it is null or has none of the image, from nothing. What is not
/// measured well (options.min_correlation, max_sigma_px) is left empty. sigma is that of matching, poses taken as
/// exact. On images of known truth it is right to a tenth where noise makes 0.12 px of parallax; where it makes less,
/// sigma is too large (by 1.6 at 0.05 px, by its floor of 0.05 px), where it makes more, too small (by 1.5 at
/// 0.25 px). Memory: about 50 bytes per pixel of the working image, besides `images` and `costs`. Images do not
/// depend on each other: the caller may run several at once (images, ties and costs are shared and thread-safe) or
/// leave the threads to this function, with the same result. Errors: kIllPosed when the image has no neighbours or too
/// few tie points, kCancelled, what the images say.
[[nodiscard]] Result<DepthMap> depth_map(const Block& block, ImageId image, const TieView& ties, WorkingImages& images,
                                         SharedBudget& costs, DepthStore* overviews, const DenseOptions& options,
                                         const Run& run);

/// The same for a single image, with nothing kept.
[[nodiscard]] Result<DepthMap> depth_map(const Block& block, ImageId image, const PixelSource& pixels,
                                         const DenseOptions& options, const Run& run);

}  // namespace collinea
