// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <span>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/block/features.h"
#include "collinea/match/pairs.h"

namespace collinea {

/// The largest features of an image. They see much of the image, survive a change of distance best, and are so few
/// that the same ones are found in both images; comparing them costs a hundredth of comparing all (Wu 2013, Towards
/// linear-time incremental structure from motion).
struct Glance {
  std::vector<std::uint32_t> index;  ///< into the image's Features
  std::vector<Descriptor> descriptors;
};

/// Two images compared by their glances.
struct LookedPair {
  ImageIdPair images;
  std::vector<Match> matches;  ///< indices into the images' Features
};

/// `features_of` is called once for each image, from one thread. Memory: 132 bytes a feature looked at. Errors: those
/// of features_of; cancelled.
[[nodiscard]] Result<std::map<ImageId, Glance>> glances(std::span<const ImageId> images,
                                                        const std::function<Result<Features>(ImageId)>& features_of,
                                                        const PairOptions& options, const Run& run);

/// Compares pairs by their glances. In the order of `pairs`. Time: about 0.1 ms a pair. Errors: cancelled.
[[nodiscard]] Result<std::vector<LookedPair>> look(const std::map<ImageId, Glance>& glances,
                                                   const std::vector<ImageIdPair>& pairs, const Run& run);

}  // namespace collinea
