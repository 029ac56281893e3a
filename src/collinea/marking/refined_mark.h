// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>

#include "collinea/base/words.h"
#include "collinea/feature/target.h"

namespace collinea {

/// What a mark was refined by.
enum class MarkedKind : std::uint8_t { kCircle, kCross, kChequerboard, kTag };
inline constexpr Word<MarkedKind> kMarkedKindWords[] = {
    {MarkedKind::kCircle, "circle", "a disc, brighter or darker than what is around; an ellipse in the image"},
    {MarkedKind::kCross, "cross", "two bars that cross"},
    {MarkedKind::kChequerboard, "chequerboard", "the corner where two dark and two bright fields meet"},
    {MarkedKind::kTag, "tag", "a coded tag, AprilTag or ArUco"}};
[[nodiscard]] constexpr std::span<const Word<MarkedKind>> words(MarkedKind) { return kMarkedKindWords; }
[[nodiscard]] MarkedKind marked_kind(TargetKind kind);
/// Nothing: a tag, which is no target of one window.
[[nodiscard]] std::optional<TargetKind> target_kind(MarkedKind kind);

/// The centre of a target near a click.
struct RefinedMark {
  MarkedKind kind = MarkedKind::kCircle;
  Eigen::Vector2d pixel;
  Eigen::Matrix2d covariance;  ///< [px^2], from the residuals of the grey values
  int radius_px = 0;           ///< of the window that was measured
  double explained = 0;        ///< part of the variance about a plane through the grey values that the model explains
  [[nodiscard]] double sigma_px() const;  ///< in the worst direction
};

inline constexpr double kLargestMiss_px = 8;  ///< of a click
/// How far about a click grey values are looked at: the largest target and a click that misses.
inline constexpr int kRefineReach_px = 36;

/// Finds the target whose centre is meant by a click: candidates of all kinds, or of one, within kLargestMiss_px, each
/// measured by least squares (measure_target()) in windows of growing size. The one counts that explains most: with n
/// pixels, residual squares S and k unknowns, against a plane through the same grey values (S0, 3 unknowns), by
///
///     n ln(S0 / S) - (k - 3) ln n       (twice the logarithm of the odds, Schwarz 1978)
///
/// Grey values whose residuals are correlated, as those of JPEG and of texture, have fewer independent ones: n in that
/// is reduced by the factor by which neighbours are alike. Nothing where no candidate explains kLeastExplained of the
/// variance, or where the centre is worse than kLargestSigma_px: there is no target, or not such a one. Nothing either
/// where the click is not inside the image. Cost: some 50 ms.
[[nodiscard]] std::optional<RefinedMark> refined_mark(const FloatImage& image, const Eigen::Vector2d& click,
                                                      std::optional<TargetKind> kind = std::nullopt);
inline constexpr double kLeastExplained = 0.9, kLargestSigma_px = 0.15;

/// The coded tag whose centre is nearest to a click, within kLargestMiss_px or a quarter of its side. Nothing: there is
/// none, or the centre is worse than kLargestSigma_px. Its `explained` is 0, its radius half its longest diagonal.
[[nodiscard]] std::optional<RefinedMark> tag_near(const FloatImage& image, const Eigen::Vector2d& click);
/// How far about a click tags are looked for: half the diagonal of the largest.
inline constexpr int kTagReach_px = 300;

}  // namespace collinea
