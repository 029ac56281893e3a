// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "collinea/feature/mark_model.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// What the pixels of a mark say of the tone of a scan (see MarkPrior), all else of the mark adjusted to it: the
/// derivative of -chi-squared / 2 at the tone that was taken, its second derivative (less its sign), and the variance
/// of the first, neighbours being correlated.
struct ToneEvidence {
  double slope = 0, information = 0, variance = 0;
};

/// A mark in a scan.
struct FoundMark {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< [px^2]
  double correlation = 0;                                    ///< of drawing and pixels; below zero: dark on bright
  /// Derivative of the position by the tone of the scan [px], and the standard deviation of that: a part of the
  /// covariance that all marks of a scan have in common. The transformation of the film does not read it: it takes marks
  /// as independent (ScanMarks).
  Eigen::Vector2d by_tone = Eigen::Vector2d::Zero();
  double sigma_tone = 0;
  ToneEvidence tone = {};
  double blur_px = 0;  ///< of a drawn mark
};

/// What is known of a mark beforehand: how it is turned against its drawing, and how well; how well its size is known,
/// and its two scales and the angle between them; and of the scan, the power `tone` of grey values that light is (1:
/// grey values are light). The tone is taken as it is; how well it is known becomes part of the covariance, where
/// `tone_information` is that of all marks (ToneEvidence) from which it was found.
struct MarkPrior {
  double rotation_rad = 0, sigma_rotation_rad = 0.03, sigma_scale = 0.03, sigma_affinity = 0.003;
  double tone = 1, sigma_tone = 0, tone_information = 0;
  double blur_px = 0;  ///< about where it was matched before; 0: nothing is known
};

/// The mark near a position (to about an eighth of its size), by least squares matching of the drawing onto the pixels:
/// shift, rotation, scale, a little affinity, gain and offset; the blur that fits best. The pixels are not resampled.
/// The covariance is that of neighbours that are correlated as the residuals are (grain, sharpening): N^-1 (sum c(d)
/// J(p)' J(p + d)) N^-1. Nothing when it does not converge, leaves the scan or correlates by less than 0.5.
[[nodiscard]] std::optional<FoundMark> match_mark(const GreyImage& scan, const MarkModel& mark,
                                                  const Eigen::Vector2d& start, const MarkPrior& prior = {});

/// Positions within `radius_px` of the predicted one that look like the mark, best first, `most` at most: correlation
/// at a reduced size, then match_mark().
[[nodiscard]] std::vector<FoundMark> search_mark(const GreyImage& scan, const MarkModel& mark,
                                                 const Eigen::Vector2d& predicted, double radius_px, int most);

}  // namespace collinea
