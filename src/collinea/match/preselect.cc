// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <numeric>

#include "collinea/base/parallel.h"
#include "collinea/match/descriptors.h"
#include "collinea/match/pairs.h"

namespace collinea {
namespace {

// The descriptors of the largest features. Large ones see much of the picture, survive a change of distance best, and
// are so few that the same ones are found in both images.
std::vector<Descriptor> largest(const Features& features, int count) {
  std::vector<std::uint32_t> order(features.keypoints.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, std::ranges::greater{},
                           [&](std::uint32_t i) { return features.keypoints[i].scale_px; });
  order.resize(std::min(order.size(), static_cast<std::size_t>(std::max(0, count))));
  std::vector<Descriptor> descriptors;
  for (const std::uint32_t i : order) descriptors.push_back(features.descriptors[i]);
  return descriptors;
}

struct Partner {
  std::size_t matches;
  ImageId image;
};

// The images with the most matches, the first of equals first.
std::vector<ImageIdPair> best_of(ImageId image, std::vector<Partner> partners, const PreselectOptions& options) {
  std::erase_if(partners, [&](const Partner& partner) {
    return partner.matches < static_cast<std::size_t>(std::max(1, options.min_matches));
  });
  std::ranges::stable_sort(partners, std::ranges::greater{}, &Partner::matches);
  partners.resize(std::min(partners.size(), static_cast<std::size_t>(std::max(0, options.partners))));
  std::vector<ImageIdPair> pairs;
  for (const Partner& partner : partners)
    pairs.emplace_back(std::min(image, partner.image), std::max(image, partner.image));
  return pairs;
}

}  // namespace

Result<std::vector<ImageIdPair>> preselect_pairs(std::span<const ImageId> wanted, std::span<const ImageId> images,
                                                 const std::function<Result<Features>(ImageId)>& features_of,
                                                 const PreselectOptions& options, const Run& run) {
  const auto cancelled = [] { return fail(Errc::kCancelled, "stopped while looking for image pairs"); };
  std::map<ImageId, std::vector<Descriptor>> descriptors;
  for (const std::span<const ImageId> list : {wanted, images})
    for (const ImageId image : list) {
      if (run.stopped()) return cancelled();
      if (descriptors.contains(image)) continue;
      COLLINEA_TRY(const Features features, features_of(image));
      descriptors[image] = largest(features, options.features);
    }

  std::vector<std::vector<ImageIdPair>> found(wanted.size());
  parallel_for(run, wanted.size(), [&](std::size_t i) {
    std::vector<Partner> partners;
    for (const ImageId other : images) {
      if (run.stopped()) return;
      if (other == wanted[i]) continue;
      partners.push_back({match_descriptors(descriptors.at(wanted[i]), descriptors.at(other), {}).size(), other});
    }
    found[i] = best_of(wanted[i], std::move(partners), options);
  });
  if (run.stopped()) return cancelled();

  std::vector<ImageIdPair> pairs;
  for (const std::vector<ImageIdPair>& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  return pairs;
}

}  // namespace collinea
