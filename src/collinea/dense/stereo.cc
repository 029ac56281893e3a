// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/stereo.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "collinea/dense/internal/disparity_measure.h"
#include "collinea/dense/internal/foreground_fattening.h"
#include "collinea/dense/internal/level.h"
#include "collinea/dense/internal/measured_sigma.h"
#include "collinea/dense/internal/pair_check.h"
#include "collinea/dense/internal/semi_global.h"

namespace collinea {
namespace {

constexpr float kSmoothReachPx = 1;                  // neighbours that differ by more belong to another surface
constexpr std::size_t kLargestVolume = 400'000'000;  // pixels times labels of a tile, a byte each

// Rims that windows made too wide. What lies behind an edge is often hidden from one image and has no disparity: it
// counts with what its row has beyond, by which it shows its grey values. `filled`: to work in.
void empty_rims(const GreyImage& left, const Run& run, FloatImage& filled, DisparityMap& map) {
  filled = map.disparity;
  fill_disparities(filled);
  dense::empty_foreground_fattening(left, kSmoothReachPx, map.sigma, filled, run);
  for (std::size_t i = 0; i < filled.data.size(); ++i)
    if (std::isnan(filled.data[i])) map.disparity.data[i] = map.sigma.data[i] = filled.data[i];
}

}  // namespace

Result<DisparityMap> match_pair(const GreyImage& left, const GreyImage& right, const DisparityRange& range,
                                const StereoOptions& options, const Run& run) {
  COLLINEA_TRY(validate(options));
  COLLINEA_TRY(dense::check_pair(left, right, range));
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
  empty_rims(left, run, disparity, map);
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
