// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/run.h"
#include "collinea/raster/raster.h"

// Filters of images of bytes, any channels, each by itself. They go through the image by strips, side by side: beside
// image and result a thread holds the rows of its strip and of the window. The same bits for any number of threads.
// `known` is a mask of the image's size, 0 where a pixel is empty: such pixels count in no window and are 0 in the
// result; nothing: there are none.
namespace collinea {

/// Weights of a Gaussian from its middle outwards, cut at four sigmas; both sides together sum to 1.
[[nodiscard]] std::vector<float> gaussian_taps(double sigma_px);

/// Multiplied with G(x) G(y), G = exp(-x^2 / (2 sigma^2)), cut at four sigmas, weights that sum to 1, the border
/// repeated, rounded (Karfis 2.3). Sigma 0: the image itself.
[[nodiscard]] Raster<std::uint8_t> gaussian_filtered(const Raster<std::uint8_t>& image, double sigma_px, const Run& run,
                                                     const GreyImage* known = nullptr);

/// Wallis' filter (1976): mean and contrast are brought near to wished ones everywhere.
struct WallisOptions {
  int window_px = 41;
  double mean_grey = 127;
  double contrast_grey = 60;
  double contrast_share = 0.8;
  double mean_share = 0.9;

  friend bool operator==(const WallisOptions&, const WallisOptions&) = default;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = WallisOptions;
    visit(Field{"wallis_window_px", &O::window_px, "px", "of wallis: width of the window, made odd", 3, 2001});
    visit(Field{"wallis_mean_grey", &O::mean_grey, "grey", "of wallis: wished mean", 0, 255});
    visit(Field{"wallis_contrast_grey", &O::contrast_grey, "grey", "of wallis: wished standard deviation", 1, 127});
    visit(
        Field{"wallis_contrast_share", &O::contrast_share, "1",
              "of wallis: 1 = the wished contrast everywhere, 0 = as it is; less than 1 limits the noise of flat parts",
              0, 1});
    visit(Field{"wallis_mean_share", &O::mean_share, "1", "of wallis: 1 = the wished mean everywhere, 0 = as it is", 0,
                1});
  }
};

/// With mean m and standard deviation s of the window around each pixel (cut at the border), wished ones M and S,
/// shares c of contrast and b of mean:
///     g' = (g - m) c S / (c s + (1 - c) S) + b M + (1 - b) m
/// Of a flat window the first part is 0. The sums are exact whole numbers, at the same cost for windows of any size.
[[nodiscard]] Raster<std::uint8_t> wallis_filtered(const Raster<std::uint8_t>& image, const WallisOptions& options,
                                                   const Run& run, const GreyImage* known = nullptr);

}  // namespace collinea
