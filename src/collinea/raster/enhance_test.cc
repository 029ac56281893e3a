// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "collinea/math/random.h"
#include "collinea/raster/dither.h"
#include "collinea/raster/grey_table.h"
#include "collinea/raster/local_filters.h"
#include "collinea/raster/pyramid.h"
#include "collinea/raster/rescale.h"

namespace collinea {
namespace {

GreyImage noisy(int width, int height, int channels, std::uint64_t seed) {
  Random random(seed);
  GreyImage image(width, height, channels);
  for (auto& value : image.data) value = static_cast<std::uint8_t>(random.below(256));
  return image;
}

GreyImage ramp(int width, int height) {
  GreyImage image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = static_cast<std::uint8_t>(255 * x / (width - 1));
  return image;
}

double mean_of(const GreyImage& image) { return statistics_of(grey_histogram(image)).mean; }

TEST(GreyStatistics, AreThoseOfTheDefinitions) {
  GreyImage image(2, 3);
  image.data = {10, 20, 20, 30, 40, 60};
  const GreyHistogram histogram = grey_histogram(image);
  const GreyStatistics s = statistics_of(histogram);
  EXPECT_EQ(s.count, 6u);
  EXPECT_EQ(s.least, 10);
  EXPECT_EQ(s.most, 60);
  EXPECT_DOUBLE_EQ(s.mean, 30);
  EXPECT_NEAR(s.contrast, std::sqrt((400 + 100 + 100 + 0 + 100 + 900) / 5.0), 1e-12);  // Karfis: n - 1
  EXPECT_NEAR(s.entropy_bit, 4 * std::log2(6.0) / 6 + 2 * std::log2(3.0) / 6, 1e-12);
  EXPECT_EQ(histogram.quantile(0), 10);
  EXPECT_EQ(histogram.quantile(0.5), 20);
  EXPECT_EQ(histogram.quantile(0.51), 30);
  EXPECT_EQ(histogram.quantile(1), 60);
  EXPECT_DOUBLE_EQ(histogram.share_up_to(29), 0.5);
  EXPECT_EQ(statistics_of(GreyHistogram{}).count, 0u);
}

// An image with empty pixels in a corner and here and there.
struct Holed {
  GreyImage image, known;

  explicit Holed(int channels, std::uint8_t fill) : image(noisy(60, 45, channels, 3)), known(60, 45, 1, 255) {
    for (int y = 0; y < 45; ++y)
      for (int x = 0; x < 60; ++x)
        if (x + y < 30 || (7 * x + 5 * y) % 13 == 0) {
          known.at(x, y) = 0;
          for (int c = 0; c < channels; ++c) image.at(x, y, c) = fill;
        }
  }
};

// Whatever an empty pixel holds: nothing that is known depends on it.
TEST(EmptyPixels, CountNowhere) {
  for (const int channels : {1, 3}) {
    const Holed black(channels, 0), white(channels, 255);
    EXPECT_EQ(grey_histogram(black.image, &black.known).count, grey_histogram(white.image, &white.known).count);
    const auto same = [&](auto&& filter) {
      const GreyImage a = filter(black), b = filter(white);
      const auto n = static_cast<std::size_t>(channels);
      std::size_t differ = 0, empty = 0;
      for (std::size_t i = 0; i < a.data.size(); ++i) {
        differ += a.data[i] != b.data[i];
        empty += black.known.data[i / n] == 0 && a.data[i] != 0;
      }
      EXPECT_EQ(differ, 0u);
      EXPECT_EQ(empty, 0u);
    };
    same([](const Holed& h) { return gaussian_filtered(h.image, 1.5, {}, &h.known); });
    same([](const Holed& h) { return wallis_filtered(h.image, {.window_px = 11}, {}, &h.known); });
    for (const Reduction reduction : {Reduction::kMean, Reduction::kSinc, Reduction::kMedian}) {
      const ReducedPart a = reduced(black.image, black.known, 2.5, reduction, {}),
                        b = reduced(white.image, white.known, 2.5, reduction, {});
      EXPECT_EQ(a.image.data, b.image.data);
      EXPECT_EQ(a.known.data, b.known.data);
      EXPECT_EQ(a.known.at(0, 0), 0);
      EXPECT_EQ(a.known.at(23, 17), 255);
    }
  }
  const Holed black(1, 0), white(1, 255);
  EXPECT_EQ(dithered_by_diffusion(black.image, 3, &black.known).data,
            dithered_by_diffusion(white.image, 3, &white.known).data);
}

// A flat image stays flat up to the rim of what is known, where zeros would darken it.
TEST(EmptyPixels, DoNotDarkenTheRim) {
  Holed flat(1, 0);
  for (std::size_t i = 0; i < flat.image.data.size(); ++i)
    if (flat.known.data[i] != 0) flat.image.data[i] = 140;
  const GreyImage smooth = gaussian_filtered(flat.image, 2, {}, &flat.known);
  for (std::size_t i = 0; i < smooth.data.size(); ++i) EXPECT_EQ(smooth.data[i], flat.known.data[i] != 0 ? 140 : 0);
  for (const Reduction reduction : {Reduction::kMean, Reduction::kSinc, Reduction::kMedian}) {
    const ReducedPart part = reduced(flat.image, flat.known, 3, reduction, {});
    for (std::size_t i = 0; i < part.image.data.size(); ++i)
      EXPECT_EQ(part.image.data[i], part.known.data[i] != 0 ? 140 : 0);
  }
}

// Where nothing is empty the mask changes nothing.
TEST(EmptyPixels, OfAFullMaskThereAreNone) {
  const GreyImage image = noisy(50, 40, 3, 9), full(50, 40, 1, 255);
  EXPECT_EQ(wallis_filtered(image, {.window_px = 9}, {}, &full).data,
            wallis_filtered(image, {.window_px = 9}, {}).data);
  EXPECT_EQ(dithered_by_diffusion(image, 4, &full).data, dithered_by_diffusion(image, 4).data);
  EXPECT_EQ(reduced(image, full, 2, Reduction::kMedian, {}).image.data, reduced(image, 2, Reduction::kMedian, {}).data);
  const GreyImage a = gaussian_filtered(image, 1.2, {}, &full), b = gaussian_filtered(image, 1.2, {});
  for (std::size_t i = 0; i < a.data.size(); ++i) EXPECT_NEAR(a.data[i], b.data[i], 1);  // rounding at the half
}

TEST(GreyTables, StretchIsLinearBetweenBlackAndWhite) {
  const GreyTable table = stretch_table(50, 150);
  EXPECT_EQ(table[0], 0);
  EXPECT_EQ(table[50], 0);
  EXPECT_EQ(table[100], 128);
  EXPECT_EQ(table[150], 255);
  EXPECT_EQ(table[255], 255);
  EXPECT_EQ(stretch_table(0, 255), identity_table());
  EXPECT_EQ(stretch_table(90, 90), threshold_table(90));
}

// Of 5 and 95 percent nine pixels of ten keep grey values of their own (Mussio 6.14).
TEST(GreyTables, NinetyPercentUseAllTheRange) {
  const GreyHistogram h = grey_histogram(ramp(2560, 4));
  const GreyTable table = stretch_table(h.quantile(0.05), h.quantile(0.95));
  std::uint64_t between = 0;
  for (std::size_t g = 0; g < kGreyValues; ++g) between += table[g] > 0 && table[g] < 255 ? h.count[g] : 0;
  EXPECT_NEAR(double(between) / double(h.total()), 0.9, 0.01);
}

TEST(GreyTables, EqualisedRangesHoldAsManyPixels) {
  Random random(2);
  GreyImage image(400, 400);
  for (auto& v : image.data) v = static_cast<std::uint8_t>(std::clamp(90 + 12 * random.normal(), 0.0, 255.0));
  const GreyTable table = equalisation_table(grey_histogram(image));
  for (auto& v : image.data) v = table[v];
  const GreyHistogram h = grey_histogram(image);
  // A grey value holds 3.3 % of the pixels at most: quarters are as even as that.
  for (const double share : {0.25, 0.5, 0.75}) EXPECT_NEAR(h.share_up_to(int(255 * share)), share, 0.034);
  EXPECT_EQ(statistics_of(h).most, 255);
  EXPECT_EQ(equalisation_table(GreyHistogram{}), identity_table());
}

TEST(GreyTables, GammaNegativeThresholdAndSlices) {
  EXPECT_EQ(gamma_table(1), identity_table());
  EXPECT_EQ(gamma_table(2)[64], 128);  // 255 sqrt(64 / 255) = 127.7
  EXPECT_EQ(chained(negative_table(), negative_table()), identity_table());
  EXPECT_EQ(chained(negative_table(), threshold_table(200))[50], 255);
  EXPECT_EQ(threshold_table(100)[99], 0);
  EXPECT_EQ(threshold_table(100)[100], 255);
  const GreyTable slices = slicing_table(4);
  EXPECT_EQ(std::set<int>(slices.begin(), slices.end()), (std::set<int>{0, 85, 170, 255}));
  EXPECT_EQ(std::ranges::count(slices, 85), 64);
}

TEST(GreyTables, OtsuPartsTwoClasses) {
  GreyHistogram h;
  h.count[40] = 70;
  h.count[50] = 30;
  h.count[180] = 20;
  h.count[190] = 80;
  EXPECT_EQ(otsu_threshold(h), (51 + 180 + 1) / 2);  // all from 51 to 180 part them alike
  GreyHistogram one;
  one.count[7] = 10;
  EXPECT_FALSE(otsu_threshold(one));
  EXPECT_FALSE(otsu_threshold(GreyHistogram{}));
}

TEST(Palettes, BeginAndEndWithTheirColours) {
  using Rgb = std::array<std::uint8_t, 3>;
  for (const auto& entry : words(Palette{})) {
    const auto table = palette_table(entry.value);
    for (std::size_t g = 1; g < kGreyValues; ++g) EXPECT_NE(table[g], table[g - 1]) << entry.word << ' ' << g;
  }
  EXPECT_EQ(palette_table(Palette::kGrey)[77], (Rgb{77, 77, 77}));
  EXPECT_EQ(palette_table(Palette::kSpectrum)[0], (Rgb{0, 0, 255}));
  EXPECT_EQ(palette_table(Palette::kSpectrum)[255], (Rgb{255, 0, 0}));
}

TEST(Reduction, ByWholeNumbersTheMeanIsThatOfThePyramid) {
  const GreyImage image = noisy(64, 48, 3, 3);
  const auto ours = reduced(image, 4, Reduction::kMean, {}), other = shrunk(image, 4);
  ASSERT_EQ(ours.width, 16);
  ASSERT_EQ(ours.data.size(), other.data.size());
  for (std::size_t i = 0; i < ours.data.size(); ++i) EXPECT_NEAR(ours.data[i], other.data[i], 1);
}

TEST(Reduction, KeepsConstantsAndRampsWhereTheyAre) {
  for (const auto& entry : words(Reduction{})) {
    for (const auto value : reduced(GreyImage(50, 31, 1, 137), 2.7, entry.value, {}).data) EXPECT_EQ(value, 137);
    GreyImage slope(300, 20);
    for (int y = 0; y < slope.height; ++y)
      for (int x = 0; x < slope.width; ++x) slope.at(x, y) = static_cast<std::uint8_t>(x / 2);
    const GreyImage small = reduced(slope, 3.5, entry.value, {});
    EXPECT_EQ(small.width, 86);
    for (int x = 5; x < small.width - 5; ++x)
      EXPECT_NEAR(small.at(x, 3), (3.5 * (x + 0.5) - 0.5) / 2 - 0.25, 0.8) << entry.word << ' ' << x;
  }
}

// A wave that three pixels can show goes through, one that only the large image can is taken away: of the mean as far
// as the sinc of its box lets it (Mussio 6.8: it also changes what can be shown).
TEST(Reduction, SincPartsTheBandsTheMeanDoesNot) {
  const auto amplitude = [](double period_px, Reduction reduction) {
    GreyImage image(960, 8);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 960; ++x)
        image.at(x, y) =
            static_cast<std::uint8_t>(std::lround(128 + 100 * std::sin(2 * std::numbers::pi * (x + 0.5) / period_px)));
    const GreyImage small = reduced(image, 4, reduction, {});
    double squares = 0;
    for (int x = 40; x < 200; ++x) squares += std::pow(small.at(x, 1) - 128.0, 2);
    return std::sqrt(2 * squares / 160);
  };
  EXPECT_NEAR(amplitude(16, Reduction::kMean), 90.6, 1);   // sin(4 pi / p) / (4 sin(pi / p))
  EXPECT_NEAR(amplitude(5.3, Reduction::kMean), 31.2, 1);  // aliased
  EXPECT_NEAR(amplitude(16, Reduction::kSinc), 100, 2);
  EXPECT_LT(amplitude(5.3, Reduction::kSinc), 8);
}

TEST(Reduction, MedianLeavesOutWhatIsWrong) {
  GreyImage image(30, 30, 1, 100);
  for (int y = 0; y < 30; y += 3)
    for (int x = 0; x < 30; x += 3) image.at(x, y) = 255;
  for (const auto value : reduced(image, 3, Reduction::kMedian, {}).data) EXPECT_EQ(value, 100);
  EXPECT_EQ(reduced(image, 3, Reduction::kMean, {}).at(2, 2), 117);
}

// Mussio 6.1: a screen of 1200 x 800 pixels of 8 bit takes 960,000 bytes, less than a megabyte.
TEST(Dithering, AScreenOfMussioD8) { EXPECT_EQ(GreyImage(1200, 800).data.size(), 960'000u); }

// Mussio 6.2: 256 colours are a cube of 6 x 6 x 6, 216 of them.
TEST(Dithering, TheColourCubeOfMussioD8) {
  Raster<std::uint8_t> all(256, 1, 3);
  for (int x = 0; x < 256; ++x)
    for (int c = 0; c < 3; ++c) all.at(x, 0, c) = static_cast<std::uint8_t>(x);
  std::array<std::set<int>, 3> shades;
  const auto out = dithered_by_diffusion(all, 6);
  for (int x = 0; x < 256; ++x)
    for (int c = 0; c < 3; ++c) shades[std::size_t(c)].insert(out.at(x, 0, c));
  EXPECT_EQ(shades[0].size() * shades[1].size() * shades[2].size(), 216u);
}

// Mussio D.8 (6.13): 10 shades of two grey values in cells of 3 x 3, 253 of 64, 280 of 32.
TEST(Dithering, CellsShowTheShadesOfMussioD8) {
  EXPECT_EQ(shades_of(2, 3), 10);
  EXPECT_EQ(shades_of(64, 2), 253);
  EXPECT_EQ(shades_of(32, 3), 280);
  for (const int cell : {2, 3, 4, 5, 8}) {
    std::set<long> sums;
    for (int g = 0; g < kGreyValues; ++g) {
      const GreyImage cells = dithered_by_cells(GreyImage(cell, cell, 1, static_cast<std::uint8_t>(g)), 2, cell);
      const auto white = std::ranges::count(cells.data, 255);
      EXPECT_EQ(white + std::ranges::count(cells.data, 0), cell * cell);
      EXPECT_EQ(white, std::lround(g / 255.0 * cell * cell)) << cell << ' ' << g;
      sums.insert(white);
    }
    EXPECT_EQ(int(sums.size()), shades_of(2, cell));
  }
}

TEST(Dithering, KeepsTheMeanOfAShade) {
  for (const int levels : {2, 3, 6})
    for (const int grey : {3, 60, 128, 200, 251}) {
      const GreyImage flat(160, 160, 1, static_cast<std::uint8_t>(grey));
      EXPECT_NEAR(mean_of(dithered_by_diffusion(flat, levels)), grey, 1) << levels;
      EXPECT_NEAR(mean_of(dithered_by_cells(flat, levels, 8)), grey, 255.0 / 128 / (levels - 1) + 0.5) << levels;
    }
  const GreyImage out = dithered_by_diffusion(noisy(40, 40, 3, 9), 6);  // the colour cube of 6 x 6 x 6
  for (const auto value : out.data) EXPECT_EQ(value % 51, 0);
}

// Not the integrals over the pixels that Karfis prints (W4): the values of his formula.
TEST(GaussianFilter, TakesTheGaussianAtTheMiddlesOfPixels) {
  GreyImage image(11, 11);
  image.at(5, 5) = 255;
  const GreyImage out = gaussian_filtered(image, 1, {});
  for (int y = 0; y < 11; ++y)
    for (int x = 0; x < 11; ++x) {
      const double g = 255 / (2 * std::numbers::pi) * std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / 2.0);
      EXPECT_NEAR(out.at(x, y), g, 0.52);
    }
}

TEST(GaussianFilter, IsTheSameInStripsAndByAnyThreads) {
  const GreyImage image = noisy(61, 300, 3, 5);
  const GreyImage one = gaussian_filtered(image, 2.3, {}), two = gaussian_filtered(image, 2.3, {.threads = 3});
  EXPECT_EQ(one.data, two.data);
  // At the edge of a strip, by the definition.
  const auto direct = [&](int x, int y, int c) {
    double sum = 0, weights = 0;
    for (int v = -10; v <= 10; ++v)
      for (int u = -10; u <= 10; ++u) {
        const double w = std::exp(-(u * u + v * v) / (2 * 2.3 * 2.3));
        weights += w;
        sum += w * image.at(std::clamp(x + u, 0, 60), std::clamp(y + v, 0, 299), c);
      }
    return sum / weights;
  };
  for (const int y : {0, 3, 127, 128, 255, 256, 299})
    for (const int x : {0, 30, 60}) EXPECT_NEAR(one.at(x, y, 1), direct(x, y, 1), 0.51) << x << ' ' << y;
  EXPECT_EQ(gaussian_filtered(image, 0, {}).data, image.data);
  EXPECT_TRUE(gaussian_filtered(GreyImage(), 2, {}).empty());
}

TEST(WallisFilter, IsItsFormulaAndTheSameByAnyThreads) {
  const GreyImage image = noisy(70, 290, 1, 6);
  const WallisOptions o{.window_px = 21, .contrast_share = 0.7, .mean_share = 0.6};
  const GreyImage out = wallis_filtered(image, o, {});
  EXPECT_EQ(out.data, wallis_filtered(image, o, {.threads = 2}).data);
  for (const int y : {0, 9, 127, 128, 200, 289})
    for (const int x : {0, 10, 35, 69}) {
      double n = 0, sum = 0, squares = 0;
      for (int v = std::max(0, y - 10); v <= std::min(289, y + 10); ++v)
        for (int u = std::max(0, x - 10); u <= std::min(69, x + 10); ++u) {
          ++n;
          sum += image.at(u, v);
          squares += std::pow(image.at(u, v), 2);
        }
      const double m = sum / n, s = std::sqrt(squares / n - m * m);
      const double g = (image.at(x, y) - m) * 0.7 * 60 / (0.7 * s + 0.3 * 60) + 0.6 * 127 + 0.4 * m;
      EXPECT_NEAR(out.at(x, y), std::clamp(g, 0.0, 255.0), 0.51) << x << ' ' << y;
    }
}

TEST(WallisFilter, BringsAllPartsToOneMeanAndContrast) {
  Random random(7);
  GreyImage image(400, 200);  // dark and flat on the left, bright and strong on the right
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 400; ++x)
      image.at(x, y) = static_cast<std::uint8_t>(
          std::clamp((x < 200 ? 40 : 170) + (x < 200 ? 6 : 20) * random.normal(), 0.0, 255.0));
  const GreyImage out = wallis_filtered(image, {.contrast_grey = 40, .contrast_share = 1, .mean_share = 1}, {});
  for (const int from : {30, 230}) {
    GreyImage part(140, 200);
    for (int y = 0; y < 200; ++y) std::copy_n(out.row(y) + from, 140, part.row(y));
    const GreyStatistics s = statistics_of(grey_histogram(part));
    EXPECT_NEAR(s.mean, 127, 1);
    EXPECT_NEAR(s.contrast, 40, 1);
  }
  for (const auto value : wallis_filtered(GreyImage(50, 50, 1, 90), {}, {}).data)
    EXPECT_EQ(value, std::lround(0.9 * 127 + 0.1 * 90));  // a flat image has no contrast to be raised
}

}  // namespace
}  // namespace collinea
