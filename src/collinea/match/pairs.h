// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/block/block.h"
#include "collinea/block/features.h"

namespace collinea {

using ImageIdPair = std::pair<ImageId, ImageId>;  ///< first < second

struct PairOptions {
  int exhaustive_below = 50;
  int neighbours = 12;
  int sequence_overlap = 6;
  std::optional<double> height_above_ground_m;
  double min_overlap = 0.3;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PairOptions;
    visit(Field{"exhaustive_below", &O::exhaustive_below, "1",
                "blocks of fewer images than this are matched all with all", 0});
    visit(Field{"neighbours", &O::neighbours, "1", "nearest images by position that each image is matched with", 1,
                1000});
    visit(Field{"sequence_overlap", &O::sequence_overlap, "1",
                "images before and after in the order of taking that each image is matched with", 0, 1000});
    visit(Field{"height_above_ground_m", &O::height_above_ground_m, "m",
                "flying height, for the size of the footprints; by default the neighbours' spacing decides", 0.0});
    visit(Field{"min_overlap", &O::min_overlap, "1",
                "with a flying height: overlap of two footprints from which their images are matched", 0.0, 1.0});
  }
};

/// The pairs of images that are worth matching: all, when the images are few; else
/// - the nearest by position, in space and, so that the strips beside are not forgotten, two in each eighth of the
/// compass
///   up to three times the usual distance of neighbours;
/// - with a flying height, those whose footprints overlap (taken as vertical, four times as many as `neighbours` at
/// most);
/// - those next to each other in the order of taking (by time where all have one, else by file name; numbers count as
///   numbers), and for images without position those 2, 4, 8 ... times as far away, so that loops may close.
/// Images without position need preselect_pairs besides: see images_to_preselect.
/// Sorted, each pair once.
[[nodiscard]] std::vector<ImageIdPair> select_pairs(const Block& setup, const PairOptions& options);

/// The images that select_pairs knows too little of: those without position in a block that is not matched all with
/// all.
[[nodiscard]] std::vector<ImageId> images_to_preselect(const Block& setup, const PairOptions& options);

struct PreselectOptions {
  int features = 256;
  int partners = 20;
  int min_matches = 5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = PreselectOptions;
    visit(Field{"features", &O::features, "1", "features of each image, the largest, that are looked at", 1, 8192});
    visit(Field{"partners", &O::partners, "1", "most partners taken for one image", 1, 1000});
    visit(Field{"min_matches", &O::min_matches, "1", "fewest matches of a partner", 1, 8192});
  }
};

/// Finds partners by what the images show: the largest features of each image of `wanted` are matched with those of all
/// of `images`, and the images with the most matches are its partners. `features_of` is called once for each image,
/// from one thread at a time. Sorted, each pair once. Memory: 128 bytes a feature looked at; time: about 0.1 ms a pair.
/// Errors: those of features_of; cancelled.
[[nodiscard]] Result<std::vector<ImageIdPair>> preselect_pairs(
    std::span<const ImageId> wanted, std::span<const ImageId> images,
    const std::function<Result<Features>(ImageId)>& features_of, const PreselectOptions& options, const Run& run);

/// The union of two sorted lists of pairs.
[[nodiscard]] std::vector<ImageIdPair> joined(std::span<const ImageIdPair> a, std::span<const ImageIdPair> b);

}  // namespace collinea
