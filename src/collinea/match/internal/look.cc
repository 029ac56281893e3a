// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/internal/look.h"

#include <algorithm>
#include <numeric>

#include "collinea/base/parallel.h"
#include "collinea/match/descriptors.h"

namespace collinea {
namespace {

tl::unexpected<Error> cancelled() { return fail(Errc::kCancelled, "stopped while looking for image pairs"); }

Glance glance_of(const Features& features, int count) {
  Glance glance;
  glance.index.resize(features.keypoints.size());
  std::iota(glance.index.begin(), glance.index.end(), 0u);
  std::ranges::stable_sort(glance.index, std::ranges::greater{},
                           [&](std::uint32_t i) { return features.keypoints[i].scale_px; });
  glance.index.resize(std::min(glance.index.size(), static_cast<std::size_t>(std::max(0, count))));
  for (const std::uint32_t i : glance.index) glance.descriptors.push_back(features.descriptors[i]);
  return glance;
}

}  // namespace

Result<std::map<ImageId, Glance>> glances(std::span<const ImageId> images,
                                          const std::function<Result<Features>(ImageId)>& features_of,
                                          const PairOptions& options, const Run& run) {
  std::map<ImageId, Glance> all;
  for (const ImageId image : images) {
    if (run.stopped()) return cancelled();
    COLLINEA_TRY(const Features features, features_of(image));
    all[image] = glance_of(features, options.look_features);
  }
  return all;
}

Result<std::vector<LookedPair>> look(const std::map<ImageId, Glance>& glances, const std::vector<ImageIdPair>& pairs,
                                     const Run& run) {
  std::vector<LookedPair> looked(pairs.size());
  parallel_for(run, pairs.size(), [&](std::size_t i) {
    const Glance &first = glances.at(pairs[i].first), &second = glances.at(pairs[i].second);
    looked[i].images = pairs[i];
    looked[i].matches = match_descriptors(first.descriptors, second.descriptors, {});
    for (Match& match : looked[i].matches) match = {first.index[match.first], second.index[match.second]};
  });
  if (run.stopped()) return cancelled();
  return looked;
}

}  // namespace collinea
