// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/raster/dither.h"
#include "collinea/raster/grey_table.h"
#include "collinea/raster/local_filters.h"
#include "collinea/raster/rescale.h"
#include "collinea/report/enhance_report.h"

namespace collinea {

/// How the range of grey is used.
enum class Contrast : std::uint8_t { kNone, kStretch, kEqualise, kWallis };
inline constexpr Word<Contrast> kContrastWords[] = {
    {Contrast::kNone, "none", "as it is"},
    {Contrast::kStretch, "stretch", "linear between two quantiles"},
    {Contrast::kEqualise, "equalise", "each range of grey for as many pixels"},
    {Contrast::kWallis, "wallis", "mean and contrast alike in all parts of the image"}};
[[nodiscard]] constexpr std::span<const Word<Contrast>> words(Contrast) { return kContrastWords; }

/// A new grey value for each, whatever the image.
enum class GreyLut : std::uint8_t { kNone, kGamma, kNegative, kThreshold, kSlices };
inline constexpr Word<GreyLut> kGreyLutWords[] = {{GreyLut::kNone, "none"},
                                                  {GreyLut::kGamma, "gamma", "a power"},
                                                  {GreyLut::kNegative, "negative"},
                                                  {GreyLut::kThreshold, "threshold", "black below, white from it on"},
                                                  {GreyLut::kSlices, "slices", "ranges of one grey value each"}};
[[nodiscard]] constexpr std::span<const Word<GreyLut>> words(GreyLut) { return kGreyLutWords; }

struct EnhanceOptions {
  bool colour = false;
  double gaussian_px = 0;
  double reduce = 1;
  Reduction reduction = Reduction::kMean;
  Contrast contrast = Contrast::kNone;
  double low_percent = 5, high_percent = 95;
  WallisOptions wallis;
  GreyLut lut = GreyLut::kNone;
  double gamma = 2;
  std::optional<int> threshold;
  int slices = 8;
  Dither dither = Dither::kNone;
  int levels = 2;
  int cell_px = 4;
  Palette palette = Palette::kGrey;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = EnhanceOptions;
    visit(Field{"colour", &O::colour, "",
                "keep the colours of the image: channels are treated alike, tables come from all of them together"});
    visit(Field{"gaussian_px", &O::gaussian_px, "px", "first: standard deviation of a Gaussian that smooths", 0, 100});
    visit(Field{"reduce", &O::reduce, "1", "then: how many times larger the pixels become", 1, 1000});
    visit(Field{"reduction", &O::reduction, "", "of reduce: from which pixels one of the result is made"});
    visit(Field{"contrast", &O::contrast, "", "then: how the range of grey is used"});
    visit(Field{"low_percent", &O::low_percent, "%", "of stretch: share of pixels that become black", 0, 100});
    visit(Field{"high_percent", &O::high_percent, "%", "of stretch: share of pixels that do not become white", 0, 100});
    visit(Part{&O::wallis});
    visit(Field{"lut", &O::lut, "", "then: a new grey value for each"});
    visit(Field{"gamma", &O::gamma, "1", "of gamma: above 1 brightens what is dark, below 1 darkens", 0.01, 100});
    visit(Field{"threshold", &O::threshold, "grey",
                "of threshold: least grey value that becomes white; nothing: where two classes differ most (Otsu)", 0,
                255});
    visit(Field{"slices", &O::slices, "1", "of slices: number of ranges of the same width", 2, 256});
    visit(Field{"dither", &O::dither, "", "then: few grey values that show shades by their mixture"});
    visit(Field{"levels", &O::levels, "1", "of dither: grey values, of each channel", 2, 256});
    visit(Field{"cell_px", &O::cell_px, "px", "of ordered: width of a cell", 2, 8});
    visit(Field{"palette", &O::palette, "", "last: colours in which grey values are shown"});
  }
};

/// Enhances an image for the eye or for measurement, in the order of the options, and writes into `folder`:
/// enhanced.png, statistics.txt (grey values after each step), histogram.txt and .svg (before and after). The images
/// are held as bytes, filters work by strips. Pixels that the file states as empty (alpha, mask, no-data value) count
/// nowhere and stay empty: enhanced.png then has an alpha channel. Errors: files, options, those of what is not done, a
/// palette for colours, a threshold to be found in one grey value.
[[nodiscard]] Result<EnhanceReport> enhance_image(const std::filesystem::path& image,
                                                  const std::filesystem::path& folder, const EnhanceOptions& options,
                                                  const Run& run);

}  // namespace collinea
