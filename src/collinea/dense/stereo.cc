// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/stereo.h"

#include <algorithm>
#include <vector>

#include "collinea/dense/internal/disparity_measure.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/measured_sigma.h"
#include "collinea/dense/internal/semi_global.h"

namespace collinea {
namespace {

constexpr float kSmoothReachPx = 1;  // neighbours that differ by more belong to another surface
constexpr int kMostDisparities = 2000;
constexpr std::size_t kLargestVolume = 400'000'000;  // pixels times labels of a tile, a byte each

Result<> check(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
               const StereoOptions& options) {
  COLLINEA_TRY(validate(options));
  if (left.empty() || right.empty()) return fail(Errc::kBadInput, "an image of the pair is empty");
  if (left.height != right.height)
    return fail(Errc::kBadInput, "the images of a rectified pair have the same height; these have " +
                                     std::to_string(left.height) + " and " + std::to_string(right.height) + " rows");
  if (range.high < range.low)
    return fail(Errc::kBadInput,
                "no disparity between " + std::to_string(range.low) + " and " + std::to_string(range.high));
  if (const std::int64_t count = std::int64_t(range.high) - range.low + 1; count > kMostDisparities)
    return fail(Errc::kBadInput, std::to_string(count) + " disparities are more than " +
                                     std::to_string(kMostDisparities) + ": use a lower resolution");
  if (range.low >= left.width || range.high <= -right.width)
    return fail(Errc::kBadInput, "disparities from " + std::to_string(range.low) + " to " + std::to_string(range.high) +
                                     " lead out of the images everywhere");
  return {};
}

}  // namespace

Result<DisparityMap> match_pair(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
                                const StereoOptions& options, const Run& run) {
  COLLINEA_TRY(check(left, right, range, options));
  const dense::DisparityCosts costs(left, right, options.cost, run);
  const GreyImage small = dense::small_changes(left);
  FloatImage disparity(left.width, left.height);
  const auto tiles = dense::stereo_tiles(left.width, left.height, range.high - range.low + 1, kLargestVolume);
  for (const dense::StereoTile& tile : tiles) {
    dense::match_tile(costs, left, right.width, small, range, options.max_left_right_px, tile, run, disparity);
    if (run.stopped()) return fail(Errc::kCancelled, "matching was stopped");
  }
  dense::remove_speckles(disparity, 1.0f, options.min_patch_px);
  const FloatImage surface = dense::smooth_surface(disparity, kSmoothReachPx, run);
  const dense::Acceptance acceptance{dense::kSigmaScale, dense::kSigmaFloorPx, dense::kSmoothSigmaPx,
                                     float(options.min_correlation), float(options.max_sigma_px)};
  DisparityMap map = dense::measure(left, right, surface, disparity, acceptance, run);
  if (run.stopped()) return fail(Errc::kCancelled, "matching was stopped");
  if (options.fill) fill_disparities(map.disparity);
  return map;
}

void fill_disparities(FloatImage& disparity) {
  std::vector<float> filled(std::size_t(disparity.width));
  for (int y = 0; y < disparity.height; ++y) {
    dense::fill_row(disparity.row(y), disparity.width, filled.data());
    std::copy(filled.begin(), filled.end(), disparity.row(y));
  }
}

}  // namespace collinea
