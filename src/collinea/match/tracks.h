// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "collinea/base/id.h"
#include "collinea/block/features.h"

namespace collinea {

/// Features of different images that show the same point.
struct Track {
  std::vector<std::pair<ImageId, std::uint32_t>> features;  ///< sorted by image, each image once; two at least

  friend bool operator==(const Track&, const Track&) = default;
};

/// Joins the matches of image pairs to tracks. Where this would put two features of one image into a track, some match
/// is wrong: then the matches of that group are joined one by one, those first that most third features confirm (by
/// matches to both of their ends), and a match that would join two features of one image is left out. So a wrong match
/// between two good tracks parts them again. Sorted by their features; the result does not depend on the order of the
/// pairs or of their matches.
[[nodiscard]] std::vector<Track> merge_tracks(std::span<const ImagePair> pairs);
/// The same for pairs that lie elsewhere.
[[nodiscard]] std::vector<Track> merge_tracks(std::span<const ImagePair* const> pairs);

}  // namespace collinea
