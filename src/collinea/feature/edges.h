// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
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

struct EdgeOptions {
  EdgeOperator edge_operator = EdgeOperator::kSobel;
  std::optional<double> sigma_px;
  std::optional<double> high, low;
  std::optional<double> noise_grey;
  int shortest = 8;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = EdgeOptions;
    visit(Field{"operator", &O::edge_operator, "", "how the change of grey values is measured"});
    visit(Field{"sigma_px", &O::sigma_px, "px",
                "of the Gaussian that smooths first; nothing: 1, of log 2, of haralick 1.4", 0, 20});
    visit(Field{"high", &O::high, "grey/px", "an edge has this amplitude somewhere; nothing: 10 times what noise makes",
                0, 1000});
    visit(Field{"low", &O::low, "grey/px", "and this one everywhere; nothing: half as much", 0, 1000});
    visit(Field{"noise_grey", &O::noise_grey, "grey",
                "standard deviation of the noise of a grey value; nothing: from the image itself", 0.01, 100});
    visit(Field{"shortest", &O::shortest, "1", "least number of points of an edge", 2, 1e6});
  }
};

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

/// Standard deviation of white noise, from what a plane through 3 x 3 pixels leaves (Immerkaer 1996, but by the median,
/// so that edges do not count). Not below what rounding to whole grey values makes, 1 / sqrt(12). 0.29 for an image of
/// less than 3 x 3 pixels.
[[nodiscard]] double noise_of(const FloatImage& image);

/// Edges: amplitude and direction of every pixel; maxima across the edge (zero crossings of `log` and `haralick`) are
/// thinned, followed from amplitudes above `high` down to `low`, and linked. Positions: maximum of a paraboloid through
/// the logarithm of 3 x 3 amplitudes, which is exact for a straight edge with a Gaussian profile; zero of the cubic
/// interpolation of the Laplacian; zero of the facet's second derivative. Standard deviations: linear propagation of
/// white noise through all filters, and 0.012 px (log) or 0.02 px (haralick) that their models are off by; grey values
/// that are correlated (JPEG, resampled images) make larger errors. Smoothing moves curved edges
/// (docs/theory/edges.md). Memory: about 24 bytes a pixel. An image of less than 7 x 7 pixels has no edges.
[[nodiscard]] EdgeMap detect_edges(const FloatImage& image, const EdgeOptions& options);

/// An image of bytes as one of numbers.
[[nodiscard]] FloatImage as_float(const GreyImage& image);

/// The image smoothed by a Gaussian, cut at four sigmas, borders repeated; sigma 0: as it is.
[[nodiscard]] FloatImage smoothed(const FloatImage& image, double sigma_px);

}  // namespace collinea
