// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <set>
#include <span>
#include <vector>

#include "collinea/match/internal/look.h"
#include "collinea/match/tracks.h"

namespace collinea {

// Which of the pairs looked at are worth a search of all their features, in three rounds. A pair's rank with an image
// is by the number of matches of the look. All lists are sorted, each pair once.

/// First round: each image with its best `sure_partners`.
[[nodiscard]] std::vector<ImageIdPair> sure_pairs(std::span<const LookedPair> looked, const PairOptions& options);

/// Second round: each image with its next best, up to `partners`, unless the tracks found so far already hold more than
/// `max_linked` of the matches that the look saw: then a search would find little new. `searched` are left out.
[[nodiscard]] std::vector<ImageIdPair> lacking_pairs(std::span<const LookedPair> looked,
                                                     const std::set<ImageIdPair>& searched,
                                                     std::span<const Track> tracks, const PairOptions& options);

/// Third round, so that no image is lost for the sake of speed: pairs that could join what does not hang together yet.
/// An image outside the largest part of the block, or with less than two verified partners, is offered its best
/// `partners` not searched so far that are in another part (for a loose image: any), however few matches the look saw;
/// blocks of less than 50 images all such pairs. Nothing when all hangs together.
[[nodiscard]] std::vector<ImageIdPair> joining_pairs(std::span<const LookedPair> looked,
                                                     const std::set<ImageIdPair>& searched,
                                                     const std::vector<ImageIdPair>& verified,
                                                     const PairOptions& options);

/// Matches of one image with others that follow from tracks.
struct SharedTracks {
  ImageIdPair images;
  std::vector<Match> matches;  ///< sorted
};

/// Finds the tracks that images have in common: pairs of images in tracks that are neighbours of neighbours.
class TrackIndex {
 public:
  explicit TrackIndex(std::span<const Track> tracks);
  /// The matches with each later image that `image` has at least `min_matches` tracks in common with, by image.
  [[nodiscard]] std::vector<SharedTracks> shared_with_later(ImageId image, std::size_t min_matches) const;
  /// Whether a track holds both features.
  [[nodiscard]] bool linked(const ImageIdPair& images, const Match& match) const;
  [[nodiscard]] std::vector<ImageId> images() const;

 private:
  struct Entry {
    std::uint32_t feature, track;
    friend auto operator<=>(const Entry&, const Entry&) = default;
  };
  [[nodiscard]] std::optional<std::uint32_t> track_of(ImageId image, std::uint32_t feature) const;

  std::span<const Track> tracks_;
  std::map<ImageId, std::vector<Entry>> entries_;  // sorted
};

}  // namespace collinea
