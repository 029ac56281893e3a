// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/partners.h"

#include <algorithm>
#include <functional>
#include <map>
#include <optional>

namespace collinea {
namespace {

constexpr std::size_t kSmallBlock = 50;  // all with all costs less than looking for the features
constexpr std::size_t kSafePartners = 2;

// The pairs looked at of each image, the best first; of equals the first.
using Ranking = std::map<ImageId, std::vector<const LookedPair*>>;

Ranking ranking_of(std::span<const LookedPair> looked) {
  Ranking ranking;
  for (const LookedPair& pair : looked)
    for (const ImageId image : {pair.images.first, pair.images.second}) ranking[image].push_back(&pair);
  for (auto& [image, pairs] : ranking)
    std::ranges::stable_sort(pairs, std::ranges::greater{},
                             [](const LookedPair* pair) { return pair->matches.size(); });
  return ranking;
}

ImageId other_of(const LookedPair& pair, ImageId image) {
  return pair.images.first == image ? pair.images.second : pair.images.first;
}

std::vector<ImageIdPair> as_list(const std::set<ImageIdPair>& pairs) { return {pairs.begin(), pairs.end()}; }

bool promises(const LookedPair& pair, const PairOptions& options) {
  return pair.matches.size() >= static_cast<std::size_t>(std::max(1, options.look_min_matches));
}

double linked_part(const LookedPair& pair, const TrackIndex& index) {
  const auto linked =
      std::ranges::count_if(pair.matches, [&](const Match& match) { return index.linked(pair.images, match); });
  return static_cast<double>(linked) / static_cast<double>(pair.matches.size());
}

// The parts of the block that verified pairs hold together, each image under the first of its part.
class Parts {
 public:
  Parts(const Ranking& images, const std::vector<ImageIdPair>& verified) {
    for (const auto& [image, pairs] : images) part_[image] = image;
    for (const auto& [a, b] : verified) {
      const ImageId one = of(a), other = of(b);
      part_[std::max(one, other)] = std::min(one, other);
      ++partners_[a];
      ++partners_[b];
    }
  }
  ImageId of(ImageId image) {
    ImageId& part = part_.try_emplace(image, image).first->second;
    if (part != image) part = of(part);
    return part;
  }
  ImageId largest() {
    std::map<ImageId, std::size_t> sizes;
    for (const auto& [image, part] : part_) ++sizes[of(image)];
    return std::ranges::max_element(sizes, {}, [](const auto& entry) { return entry.second; })->first;
  }
  bool is_loose(ImageId image) { return partners_[image] < kSafePartners; }

 private:
  std::map<ImageId, ImageId> part_;
  std::map<ImageId, std::size_t> partners_;
};

}  // namespace

std::vector<ImageIdPair> sure_pairs(std::span<const LookedPair> looked, const PairOptions& options) {
  std::set<ImageIdPair> wanted;
  for (const auto& [image, pairs] : ranking_of(looked))
    for (std::size_t k = 0; k < pairs.size() && k < static_cast<std::size_t>(options.sure_partners); ++k)
      if (promises(*pairs[k], options)) wanted.insert(pairs[k]->images);
  return as_list(wanted);
}

std::vector<ImageIdPair> lacking_pairs(std::span<const LookedPair> looked, const std::set<ImageIdPair>& searched,
                                       std::span<const Track> tracks, const PairOptions& options) {
  const TrackIndex index(tracks);
  std::set<ImageIdPair> wanted;
  for (const auto& [image, pairs] : ranking_of(looked))
    for (std::size_t k = 0; k < pairs.size() && k < static_cast<std::size_t>(options.partners); ++k)
      if (promises(*pairs[k], options) && !searched.contains(pairs[k]->images) &&
          linked_part(*pairs[k], index) <= options.max_linked)
        wanted.insert(pairs[k]->images);
  return as_list(wanted);
}

std::vector<ImageIdPair> joining_pairs(std::span<const LookedPair> looked, const std::set<ImageIdPair>& searched,
                                       const std::vector<ImageIdPair>& verified, const PairOptions& options) {
  std::set<ImageIdPair> wanted;
  const Ranking ranking = ranking_of(looked);
  if (ranking.empty()) return {};
  Parts parts(ranking, verified);
  const ImageId largest = parts.largest();
  const std::size_t most = ranking.size() < kSmallBlock ? ranking.size() : static_cast<std::size_t>(options.partners);
  for (const auto& [image, pairs] : ranking) {
    if (parts.of(image) == largest && !parts.is_loose(image)) continue;
    std::size_t taken = 0;
    for (const LookedPair* pair : pairs) {
      const bool joins = parts.is_loose(image) || parts.of(other_of(*pair, image)) != parts.of(image);
      if (taken == most || !joins || searched.contains(pair->images)) continue;
      wanted.insert(pair->images);
      ++taken;
    }
  }
  return as_list(wanted);
}

TrackIndex::TrackIndex(std::span<const Track> tracks) : tracks_(tracks) {
  for (std::uint32_t track = 0; track < tracks.size(); ++track)
    for (const auto& [image, feature] : tracks[track].features) entries_[image].push_back({feature, track});
  for (auto& [image, entries] : entries_) std::ranges::sort(entries);
}

std::vector<SharedTracks> TrackIndex::shared_with_later(ImageId image, std::size_t min_matches) const {
  std::map<ImageId, std::vector<Match>> matches;
  if (const auto found = entries_.find(image); found != entries_.end())
    for (const Entry& entry : found->second)
      for (const auto& [other, feature] : tracks_[entry.track].features)
        if (other > image) matches[other].emplace_back(entry.feature, feature);
  std::vector<SharedTracks> shared;
  for (auto& [other, list] : matches)
    if (list.size() >= min_matches) shared.push_back({{image, other}, std::move(list)});
  return shared;
}

std::optional<std::uint32_t> TrackIndex::track_of(ImageId image, std::uint32_t feature) const {
  const auto found = entries_.find(image);
  if (found == entries_.end()) return std::nullopt;
  const auto entry = std::ranges::lower_bound(found->second, feature, {}, &Entry::feature);
  if (entry == found->second.end() || entry->feature != feature) return std::nullopt;
  return entry->track;
}

bool TrackIndex::linked(const ImageIdPair& images, const Match& match) const {
  const auto first = track_of(images.first, match.first);
  return first && first == track_of(images.second, match.second);
}

std::vector<ImageId> TrackIndex::images() const {
  std::vector<ImageId> list;
  for (const auto& [image, entries] : entries_) list.push_back(image);
  return list;
}

}  // namespace collinea
