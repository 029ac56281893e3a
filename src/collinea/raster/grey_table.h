// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "collinea/base/words.h"
#include "collinea/raster/raster.h"

// Grey values of 8 bits: how they are distributed, and tables that give each of them another (point operations).
namespace collinea {

inline constexpr int kGreyValues = 256;

/// How often each grey value occurs, all channels together.
struct GreyHistogram {
  std::array<std::uint64_t, kGreyValues> count{};

  [[nodiscard]] std::uint64_t total() const;
  /// The smallest grey value that at least this share (0 .. 1) of all does not exceed; 0 of an empty image.
  [[nodiscard]] int quantile(double share) const;
  /// Share of the values up to and including this one.
  [[nodiscard]] double share_up_to(int grey) const;
};
/// `known`: a mask of the image's size, 0 where a pixel is empty and does not count; nothing: all count.
[[nodiscard]] GreyHistogram grey_histogram(const Raster<std::uint8_t>& image, const GreyImage* known = nullptr);

/// Karfis 1.2: brightness is the mean, contrast the standard deviation sqrt(sum (g - mean)^2 / (n - 1)).
struct GreyStatistics {
  std::uint64_t count = 0;
  int least = 0, most = 0;
  double mean = 0, contrast = 0;  ///< [grey]; contrast 0 of fewer than two values
  double entropy_bit = 0;         ///< -sum p log2 p: 0 of a constant image, 8 where all values are as frequent
};
[[nodiscard]] GreyStatistics statistics_of(const GreyHistogram& histogram);

/// The new grey value of each: a look-up table (LUT).
using GreyTable = std::array<std::uint8_t, kGreyValues>;

[[nodiscard]] GreyTable identity_table();
/// What `second` makes of what `first` made.
[[nodiscard]] GreyTable chained(const GreyTable& first, const GreyTable& second);
/// 0 up to `black`, 255 from `white` on, linear between (Mussio 6.12, 6.14 with the 5 % and 95 % quantiles). Where
/// white <= black, the values from `white` on are 255, the others 0.
[[nodiscard]] GreyTable stretch_table(int black, int white);
/// 255 times the share of the values up to g (Karfis 1.2, Mussio 6.15): all ranges of the result hold as many pixels,
/// as far as whole grey values can be told apart. Identity for an empty histogram.
[[nodiscard]] GreyTable equalisation_table(const GreyHistogram& histogram);
/// 255 (g / 255)^(1 / gamma): above 1 brightens what is dark.
[[nodiscard]] GreyTable gamma_table(double gamma);
[[nodiscard]] GreyTable negative_table();
/// 255 from `least` on, 0 below.
[[nodiscard]] GreyTable threshold_table(int least);
/// `slices` >= 2 ranges of the same width, each shown by one grey value (i - 1) / (N - 1) of 255 (Mussio 6.2).
[[nodiscard]] GreyTable slicing_table(int slices);

/// The least grey value of the bright class where the variance between two classes is largest (Otsu 1979); in the
/// middle of a range where several are. Nothing where there are fewer than two grey values.
[[nodiscard]] std::optional<int> otsu_threshold(const GreyHistogram& histogram);

/// Colours in which grey values are shown.
enum class Palette : std::uint8_t { kGrey, kHeat, kSpectrum, kOpposite };
inline constexpr Word<Palette> kPaletteWords[] = {
    {Palette::kGrey, "grey", "black to white"},
    {Palette::kHeat, "heat", "black, red, yellow, white: grows brighter throughout"},
    {Palette::kSpectrum, "spectrum", "blue, cyan, green, yellow, red"},
    {Palette::kOpposite, "opposite", "blue, white, red: the middle grey value is white"}};
[[nodiscard]] constexpr std::span<const Word<Palette>> words(Palette) { return kPaletteWords; }

/// Red, green and blue of each grey value, linear between the colours named.
[[nodiscard]] std::array<std::array<std::uint8_t, 3>, kGreyValues> palette_table(Palette palette);

}  // namespace collinea
