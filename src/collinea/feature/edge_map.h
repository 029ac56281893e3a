// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

namespace collinea {

/// How the change of grey values is measured. Gradients of two masks: Roberts, Prewitt, Sobel, isotropic. Compass: one
/// mask turned by 45 degrees seven times, the largest response counts. Zero crossings: of the Laplacian of a Gaussian
/// (Marr and Hildreth 1980), of the second derivative along the gradient of a cubic facet (Haralick 1984).
enum class EdgeOperator : std::uint8_t {
  kRoberts,
  kPrewitt,
  kSobel,
  kIsotropic,
  kPrewittCompass,
  kKirsch,
  kRobinson3,
  kRobinson5,
  kLog,
  kHaralick
};
inline constexpr Word<EdgeOperator> kEdgeOperatorWords[] = {
    {EdgeOperator::kRoberts, "roberts"},
    {EdgeOperator::kPrewitt, "prewitt"},
    {EdgeOperator::kSobel, "sobel"},
    {EdgeOperator::kIsotropic, "isotropic"},
    {EdgeOperator::kPrewittCompass, "prewitt-compass"},
    {EdgeOperator::kKirsch, "kirsch"},
    {EdgeOperator::kRobinson3, "robinson3"},
    {EdgeOperator::kRobinson5, "robinson5"},
    {EdgeOperator::kLog, "log", "zero crossings of the Laplacian of a Gaussian"},
    {EdgeOperator::kHaralick, "haralick", "zero crossings of the second derivative along the gradient"}};
[[nodiscard]] constexpr std::span<const Word<EdgeOperator>> words(EdgeOperator) { return kEdgeOperatorWords; }

/// 3 x 3 weights, upper row first, by which an image is multiplied and added up (correlation, not convolution).
using EdgeMask = std::array<double, 9>;

/// The masks of an operator as literature prints them: two (a Roberts mask in the upper left 2 x 2), eight of a compass
/// in steps of 45 degrees, none of the zero crossings. The sum of each is 0.
[[nodiscard]] std::vector<EdgeMask> edge_masks(EdgeOperator of);

/// A point of an edge, between pixels.
struct EdgePoint {
  Eigen::Vector2d at;      ///< [px]
  Eigen::Vector2d normal;  ///< unit, across the edge, towards what is brighter
  double amplitude = 0;    ///< slope of the grey values across [grey/px]
  double sigma_px = 0;     ///< of the position across the edge, from the noise of the grey values
};

/// Neighbouring points, brighter pixels on the left of who follows them (y down).
struct EdgeChain {
  std::size_t first = 0, count = 0;  ///< among EdgeMap::points
  bool is_closed = false;
};

/// Edges of an image.
struct EdgeMap {
  FloatImage amplitude;      ///< of every pixel [grey/px]; largest response of a compass
  FloatImage direction_rad;  ///< of the strongest increase, from x to y; of a compass in steps of 45 degrees
  double noise_grey = 0;     ///< given or estimated
  double high = 0, low = 0;  ///< as used [grey/px]
  /// Errors of points of one edge at the distance d are correlated by exp(-d^2 / (4 along^2)): filters overlap [px].
  double along_px = 0;
  std::vector<EdgePoint> points;  ///< in the order of the chains
  std::vector<EdgeChain> chains;

  [[nodiscard]] std::span<const EdgePoint> points_of(const EdgeChain& chain) const {
    return std::span(points).subspan(chain.first, chain.count);
  }
};

}  // namespace collinea
