// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/finding.h"
#include "collinea/base/words.h"
#include "collinea/block/block.h"
#include "collinea/quality/examine.h"

namespace collinea {

/// What is asked of residuals.
enum class ResidualTestKind : std::uint8_t {
  kRuns,             ///< signs change as often as by chance
  kAutocorrelation,  ///< neighbours are not correlated
  kNormal,           ///< they are distributed normally, whatever their scale
  kTieErrors,        ///< they are distributed as tie points are tested (TieErrors)
};
inline constexpr Word<ResidualTestKind> kResidualTestKindWords[] = {
    {ResidualTestKind::kRuns, "runs"},
    {ResidualTestKind::kAutocorrelation, "autocorrelation"},
    {ResidualTestKind::kNormal, "normal"},
    {ResidualTestKind::kTieErrors, "tie_errors"}};
[[nodiscard]] constexpr std::span<const Word<ResidualTestKind>> words(ResidualTestKind) {
  return kResidualTestKindWords;
}

/// Residuals in an order.
enum class ResidualSeries : std::uint8_t {
  kPositions,   ///< of image positions, east, north, up, in the order flown
  kImageMeans,  ///< means over each image, columns and rows, in the order flown
  kInImages,    ///< of tie points within each image of a camera, columns and rows, in bands across the image
  kTiePoints,   ///< one of each tie point; no order
};
inline constexpr Word<ResidualSeries> kResidualSeriesWords[] = {{ResidualSeries::kPositions, "positions"},
                                                                {ResidualSeries::kImageMeans, "image_means"},
                                                                {ResidualSeries::kInImages, "in_images"},
                                                                {ResidualSeries::kTiePoints, "tie_points"}};
[[nodiscard]] constexpr std::span<const Word<ResidualSeries>> words(ResidualSeries) { return kResidualSeriesWords; }

/// The outcome of one test.
struct ResidualTest {
  ResidualTestKind kind{};
  ResidualSeries series{};
  int axis = 0;                         ///< 0 column or east, 1 row or north, 2 height
  std::optional<int> strip;             ///< number of the strip; nothing: all images in the order flown
  std::optional<CameraId> camera;       ///< of kInImages
  long count = 0;                       ///< residuals, or of kRuns pairs of neighbours
  double value = 0;                     ///< changes of sign, correlation, or largest distance between distributions
  double expected = 0;                  ///< of independent residuals; of a distance what it exceeds half the time
  double correlation = 0;               ///< of neighbours, from either of the first two kinds
  double rms = 0;                       ///< of the residuals [m, px]
  double p_value = 1, p_corrected = 1;  ///< by itself; for the number of tests (Holm 1979)
  bool significant = false;             ///< p_corrected is below the level
};

/// Tests of the residuals of an adjustment that assume no distribution, or test it. For each test the residuals are
/// made independent, or chosen so that they nearly are:
///
/// - Positions: those of the adjustment, whitened in the order flown (whitened_positions()). Independent but for
///   correlations between axes and with images farther than 20 before. Two-sided.
/// - Means over an image, of residuals in their own standard deviations v / (sigma0 sigma sqrt(r)): each tie point
///   takes part with one of its rays, so that no point ties two images together; what poses have in common remains,
///   and makes neighbours a little unlike: only those alike are tested. The equations of the pose keep such means near
///   0, so that a drift of the camera shows elsewhere (residual_section()).
/// - In images: the same rays, neighbours in bands across the image. A pose and a camera take a few unknowns from
///   hundreds of residuals, which makes neighbours a little unlike: only those alike are tested. Images with fewer
///   than 30 such rays are left out.
/// - Tie points: the same rays; distributions. Kolmogorov's distance, against normal ones of the scale that they
///   have, and against the distribution by which they are tested where that is another (with its rejected gross
///   errors).
///
/// Strips have tests of their own from 12 images on, where there are several. Coordinates with a redundancy number
/// below 0.05 take no part. `strips`: the order flown; empty: that of times, or else of ids.
///
/// Cost: n log n in the tie points. Without Examined::reliability only what needs none.
[[nodiscard]] std::vector<ResidualTest> residual_tests(const Block& block, const Examined& adjusted,
                                                       std::span<const std::map<ImageId, double>> strips, double level);

/// What is significant, a finding for each series: of several tests of it, axes and strips that with the smallest
/// chance.
[[nodiscard]] std::vector<Finding> residual_findings(const std::vector<ResidualTest>& tests);

}  // namespace collinea
