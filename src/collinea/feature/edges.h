// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "collinea/base/options.h"
#include "collinea/feature/edge_map.h"

namespace collinea {

struct EdgeOptions {
  EdgeOperator edge_operator = EdgeOperator::kSobel;
  std::optional<double> sigma_px;
  std::optional<double> high, low;
  double most_edges = 0.1;
  std::optional<double> noise_grey;
  int shortest = 8;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = EdgeOptions;
    visit(Field{"operator", &O::edge_operator, "", "how the change of grey values is measured"});
    visit(Field{"sigma_px", &O::sigma_px, "px",
                "of the Gaussian that smooths first; nothing: 1, of log 2, of haralick 1.4", 0, 20});
    visit(Field{"high", &O::high, "grey/px",
                "an edge has this amplitude somewhere; nothing: 10 times what noise makes, "
                "or what `most_edges` of the pixels exceed, whichever is more",
                0, 1000});
    visit(Field{"low", &O::low, "grey/px", "and this one everywhere; nothing: half as much", 0, 1000});
    visit(Field{"most_edges", &O::most_edges, "1",
                "share of the pixels whose amplitude may reach `high` where that is not given; 1 = noise alone decides",
                0.001, 1});
    visit(Field{"noise_grey", &O::noise_grey, "grey",
                "standard deviation of the noise of a grey value; nothing: from the image itself", 0.01, 100});
    visit(Field{"shortest", &O::shortest, "1", "least number of points of an edge", 2, 1e6});
  }
};

/// Standard deviation of white noise, from what a plane through 3 x 3 pixels leaves (Immerkaer 1996, but by the median,
/// so that edges do not count). Not below what rounding to whole grey values makes, 1 / sqrt(12). 0.29 for an image of
/// less than 3 x 3 pixels.
[[nodiscard]] double noise_of(const FloatImage& image);

/// Edges. Thresholds, where not given: noise alone would call all texture of a wall an edge, so that no more than a
/// share of the pixels may be of that amplitude (the histogram's part). Amplitude and direction of every pixel; maxima
/// across the edge (zero crossings of `log` and `haralick`) are thinned, followed from amplitudes above `high` down to
/// `low`, and linked. Positions: maximum of a paraboloid through the logarithm of 3 x 3 amplitudes, which is exact for
/// a straight edge with a Gaussian profile; zero of the cubic interpolation of the Laplacian; zero of the facet's
/// second derivative. Standard deviations: linear propagation of white noise through all filters, and 0.012 px (log) or
/// 0.02 px (haralick) that their models are off by; grey values that are correlated (JPEG, resampled images) make
/// larger errors. Smoothing moves curved edges (docs/theory/edges.md). Memory: about 24 bytes a pixel. An image of less
/// than 7 x 7 pixels has no edges.
[[nodiscard]] EdgeMap detect_edges(const FloatImage& image, const EdgeOptions& options);

/// An image of bytes as one of numbers.
[[nodiscard]] FloatImage as_float(const GreyImage& image);

/// The image smoothed by a Gaussian, cut at four sigmas, borders repeated; sigma 0: as it is.
[[nodiscard]] FloatImage smoothed(const FloatImage& image, double sigma_px);

}  // namespace collinea
