// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "collinea/base/options.h"
#include "collinea/base/words.h"
#include "collinea/feature/sift.h"

namespace collinea {

/// Which points of an image are described and matched.
enum class Detector : std::uint8_t { kSift, kHarris, kFoerstner };
inline constexpr Word<Detector> kDetectorWords[] = {
    {Detector::kSift, "sift", "blobs of all scales"},
    {Detector::kHarris, "harris", "corners by Harris' measure, top of a paraboloid"},
    {Detector::kFoerstner, "foerstner", "round corners, junctions and circles, located by least squares"}};
[[nodiscard]] constexpr std::span<const Word<Detector>> words(Detector) { return kDetectorWords; }

/// What is looked for in an image.
struct DetectOptions {
  Detector detector = Detector::kSift;
  int corner_levels = 4;
  SiftOptions sift;  ///< of corners too: number, least contrast and evenness

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = DetectOptions;
    visit(Field{"detector", &O::detector, "", "which points are matched; all have SIFT's descriptor"});
    visit(Field{"corner_levels", &O::corner_levels, "1",
                "of harris and foerstner: levels of the pyramid, each of half the size, in which corners are looked "
                "for; 1 = in the image alone, at a fixed scale",
                1, 10});
    visit(Part{&O::sift});
  }
};

/// The features of an image by the detector chosen, strongest first. With kSift those of detect_sift(). Corners (Harris
/// and Stephens 1988; Foerstner and Guelch 1987) are looked for in every level of a pyramid of means over 2 x 2 pixels;
/// a level gets a quarter of the features of the one below it, the image what is left. Each is described as SIFT would
/// (main directions, RootSIFT) at a blur of 2.54 px of its level, which is its `scale_px`; Levels are a factor of
/// two apart, so that a corner is found again where the scale of two views differs by a factor of up to about 1.4.
/// Strength: the contrast that the response stands for, in part beside that of the region (SiftOptions::evenness).
///
/// Single-threaded and without chance.
[[nodiscard]] Features detect_features(const GreyImage& image, const DetectOptions& options);

/// The memory that takes, with the image. Of corners about 13 bytes a pixel.
[[nodiscard]] std::size_t bytes_to_detect(int width, int height, const DetectOptions& options);

}  // namespace collinea
