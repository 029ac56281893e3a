// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "collinea/base/run.h"
#include "collinea/dense/internal/disparity_map.h"
#include "collinea/dense/internal/local_pair.h"

namespace collinea::dense {

/// How unlike the windows around two pixels of a rectified pair are: 48 for what has nothing in common, 24 for what
/// chance gives.
///
///   census  5 x 5, each of the 24 pixels around whether it is darker (Zabih and Woodfill 1994); 2 a bit
///   zncc    24 (1 - rho), rho over 7 x 7
///   rank    rank of the pixel in 7 x 7; mean difference of ranks over 5 x 5; 2 a rank
///   sad     mean absolute difference over 5 x 5; 2 a grey value
///   ssd     root of the mean squared difference over 5 x 5; 2 a grey value
inline constexpr int kLargestCost = 48, kChanceCost = 24;

/// The costs of a pair, row by row. Rows may be asked for from several threads.
class DisparityCosts {
 public:
  /// The images must outlive it; grey value 0 means "nothing there".
  DisparityCosts(const GreyImage& left, const GreyImage& right, StereoCost kind, const Run& run);

  /// costs[(x - x0) * stride + k] of the columns [x0, x1) of row y, label k being disparity low + k; 255 for k >=
  /// labels. Where the right image has nothing: kChanceCost.
  void row(int y, int x0, int x1, int low, int labels, int stride, std::uint8_t* costs) const;

 private:
  void window_row(int y, int x0, int x1, int low, int labels, int stride, std::uint8_t* costs) const;
  /// Of the windows round column x and column `other` of row y, by the sum of their terms.
  [[nodiscard]] float window_cost(int x, int other, int y, int sum) const;

  const GreyImage& left_;
  const GreyImage& right_;
  StereoCost kind_;
  GreyImage left_census_, right_census_;  ///< kCensusBytes rows for each of the image, the latter from right to left
  std::optional<LocalPlanes> left_planes_, right_planes_;  ///< grey values or ranks, of all but census
  FloatImage left_deviation_, right_deviation_;            ///< root of the sum of squared deviations in a window
  Raster<std::int32_t> left_sum_, right_sum_;              ///< of grey values in a window
};

}  // namespace collinea::dense
