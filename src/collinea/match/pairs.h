// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/block/block.h"

namespace collinea {

using ImageIdPair = std::pair<ImageId, ImageId>;  ///< first < second

/// What PairOptions::pairs may be.
enum class PairChoice { kAuto, kAll };
inline constexpr Word<PairChoice> kPairChoiceWords[] = {
    {PairChoice::kAuto, "auto", "each image with its best partners"}, {PairChoice::kAll, "all"}};
[[nodiscard]] constexpr std::span<const Word<PairChoice>> words(PairChoice) { return kPairChoiceWords; }

struct PairOptions {
  PairChoice pairs = PairChoice::kAuto;
  int exhaustive_below = 10;
  int partners = 8;
  int sure_partners = 3;
  double max_linked = 0.5;
  int candidates = 60;
  int neighbours = 24;
  int sequence_overlap = 6;
  std::optional<double> height_above_ground_m;
  int look_features = 512;
  int look_min_matches = 5;
  bool closure = true;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PairOptions;
    visit(Field{"pairs", &O::pairs, "", "which pairs are searched for matches"});
    visit(Field{"exhaustive_below", &O::exhaustive_below, "1",
                "blocks of fewer images than this are matched all with all", 0});
    visit(Field{"partners", &O::partners, "1", "most partners that each image is searched with", 1, 1000});
    visit(Field{"sure_partners", &O::sure_partners, "1",
                "partners that each image is searched with at once; the others only where tie points lack", 1, 1000});
    visit(Field{"max_linked", &O::max_linked, "1",
                "further partners are left out when tie points hold more than this part of the matches of a first look",
                0.0, 1.0});
    visit(Field{"candidates", &O::candidates, "1",
                "most similar images that each image is compared with in a first look", 1, 10000});
    visit(Field{"neighbours", &O::neighbours, "1", "nearest images by position that each image is compared with", 0,
                1000});
    visit(Field{"sequence_overlap", &O::sequence_overlap, "1",
                "images before and after in the order of taking that each image is compared with", 0, 1000});
    visit(Field{"height_above_ground_m", &O::height_above_ground_m, "m",
                "flying height, for the point that a tilted camera looks at; by default that above take-off", 0.0});
    visit(Field{"look_features", &O::look_features, "1", "features of each image, the largest, that a first look uses",
                16, 8192});
    visit(Field{"look_min_matches", &O::look_min_matches, "1", "fewest matches of a partner in a first look", 1, 8192});
    visit(Field{"closure", &O::closure, "",
                "verify the pairs that follow from tie points too, without a search of their own"});
  }
};

/// Whether every image is to be searched with every other: asked for, or the block is small.
[[nodiscard]] bool all_pairs_wanted(const Block& setup, const PairOptions& options);
[[nodiscard]] std::vector<ImageIdPair> all_pairs(const Block& setup);

/// The pairs that deserve a look by what is known before any feature is compared, their number growing as that of the
/// images:
/// - the `neighbours` nearest by position, in space and by the point looked at (position, attitude and height above
///   ground; cameras that look at the horizon have none), and, so that the strips beside are not forgotten, two in each
///   eighth of the compass among the 128 nearest;
/// - those next to each other in the order of taking (by time where all have one, else by file name; numbers count as
///   numbers), and for images without position those 2, 4, 8 ... times as far away, so that loops may close.
/// Sorted, each pair once.
[[nodiscard]] std::vector<ImageIdPair> candidate_pairs(const Block& setup, const PairOptions& options);

/// The union of two sorted lists of pairs.
[[nodiscard]] std::vector<ImageIdPair> joined(const std::vector<ImageIdPair>& a, const std::vector<ImageIdPair>& b);

}  // namespace collinea
