// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/block_parts.h"

#include <optional>
#include <set>
#include <utility>

#include "collinea/orient/internal/global.h"
#include "collinea/orient/internal/incremental.h"
#include "collinea/orient/internal/weak_cases.h"

namespace collinea {
namespace {

constexpr std::size_t kSmallestPart = 3;  // images of a part that is named as one; of two each stands alone

std::vector<ImageId> images_of(const Reconstruction& part) {
  std::vector<ImageId> images;
  for (const auto& [image, pose] : part.poses()) images.push_back(image);
  return images;
}

bool begins_globally(const Block& setup, const OrientOptions& options) {
  return options.mode == OrientMode::kGlobal ||
         (options.mode == OrientMode::kAuto && options.use_positions && worth_global(setup));
}

// Global solution, where it is asked for or worth it. Answers whether the block was placed.
Result<bool> begin(Reconstruction& block, const Block& setup, std::span<const ImagePair> pairs,
                   const OrientOptions& options, const Run& run) {
  if (!begins_globally(setup, options)) return false;
  COLLINEA_TRY(const bool placed, orient_globally(block, setup, pairs, options, run));
  if (!placed && options.mode == OrientMode::kGlobal)
    return fail(Errc::kIllPosed,
                "the positions of the images do not fix the block (too few, all on one line, or they contradict "
                "the pairs): orient image after image",
                {"mode"_option});
  return placed;
}

// Parts of the images that the first one did not reach. One that is larger takes its place.
Result<> grow_others(BlockParts& parts, std::span<const ImagePair> pairs, const OrientOptions& options,
                     const Run& run) {
  std::set<ImageId> taken;
  for (const auto& [image, pose] : parts.largest.poses()) taken.insert(image);
  std::optional<Reconstruction> part;  // it has all tracks: there are two at most
  while (can_start(pairs, taken)) {
    if (!part) part = parts.largest;
    part->forget();
    COLLINEA_TRY(grow(*part, pairs, taken, options, run));
    if (part->poses().size() < 2) break;
    for (const auto& [image, pose] : part->poses()) taken.insert(image);
    if (part->poses().size() > parts.largest.poses().size()) {
      std::swap(*part, parts.largest);
      parts.in_world = false;
    }
    if (part->poses().size() >= kSmallestPart) parts.others.push_back(images_of(*part));
  }
  return {};
}

}  // namespace

Result<BlockParts> grow_parts(const Block& setup, std::span<const ImagePair> pairs, const KeypointSource& keypoints,
                              const OrientOptions& options, const Run& run) {
  COLLINEA_TRY(Reconstruction empty, Reconstruction::create(setup, pairs, keypoints, options));
  empty.sleep_surplus();
  BlockParts parts{std::move(empty), false, {}};
  COLLINEA_TRY(parts.in_world, begin(parts.largest, setup, pairs, options, run));
  COLLINEA_TRY(grow(parts.largest, pairs, {}, options, run));
  if (parts.largest.poses().size() < 2) return tl::unexpected(nothing_fits(pairs));
  COLLINEA_TRY(grow_others(parts, pairs, options, run));
  parts.largest.wake_all();
  parts.largest.extend_all(run);
  return parts;
}

}  // namespace collinea
