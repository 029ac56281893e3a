// SPDX-License-Identifier: Apache-2.0
#include "collinea/raster/grey_table.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace collinea {
namespace {

using Rgb = std::array<std::uint8_t, 3>;

GreyTable table_of(auto&& value) {
  GreyTable table{};
  for (int g = 0; g < kGreyValues; ++g)
    table[std::size_t(g)] = static_cast<std::uint8_t>(std::clamp(std::lround(value(g)), 0L, 255L));
  return table;
}

std::vector<Rgb> colours_of(Palette palette) {
  switch (palette) {
    case Palette::kHeat:
      return {{0, 0, 0}, {200, 0, 0}, {255, 200, 0}, {255, 255, 255}};
    case Palette::kSpectrum:
      return {{0, 0, 255}, {0, 255, 255}, {0, 255, 0}, {255, 255, 0}, {255, 0, 0}};
    case Palette::kOpposite:
      return {{20, 60, 170}, {255, 255, 255}, {180, 20, 30}};
    case Palette::kGrey:
      break;
  }
  return {{0, 0, 0}, {255, 255, 255}};
}

}  // namespace

std::uint64_t GreyHistogram::total() const { return std::accumulate(count.begin(), count.end(), std::uint64_t{0}); }

int GreyHistogram::quantile(double share) const {
  const double wanted = share * static_cast<double>(total());
  std::uint64_t sum = 0;
  int last = 0;
  for (int g = 0; g < kGreyValues; ++g) {
    if (count[std::size_t(g)] == 0) continue;
    sum += count[std::size_t(g)];
    last = g;
    if (static_cast<double>(sum) >= wanted) return g;
  }
  return last;
}

double GreyHistogram::share_up_to(int grey) const {
  const std::uint64_t all = total();
  const auto sum =
      std::accumulate(count.begin(), count.begin() + std::clamp(grey + 1, 0, kGreyValues), std::uint64_t{0});
  return all == 0 ? 0 : static_cast<double>(sum) / static_cast<double>(all);
}

GreyHistogram grey_histogram(const Raster<std::uint8_t>& image, const GreyImage* known) {
  if (known) {
    GreyHistogram out;
    const auto channels = static_cast<std::size_t>(image.channels);
    for (std::size_t i = 0; i < image.data.size(); ++i) out.count[image.data[i]] += known->data[i / channels] != 0;
    return out;
  }
  // Four counters: equal neighbours do not wait for each other.
  std::array<std::array<std::uint64_t, kGreyValues>, 4> parts{};
  const std::size_t whole = image.data.size() / 4 * 4;
  for (std::size_t i = 0; i < whole; i += 4)
    for (std::size_t k = 0; k < 4; ++k) ++parts[k][image.data[i + k]];
  for (std::size_t i = whole; i < image.data.size(); ++i) ++parts[0][image.data[i]];
  GreyHistogram out;
  for (const auto& part : parts)
    for (std::size_t g = 0; g < kGreyValues; ++g) out.count[g] += part[g];
  return out;
}

GreyStatistics statistics_of(const GreyHistogram& histogram) {
  GreyStatistics out{.count = histogram.total()};
  if (out.count == 0) return out;
  const auto n = static_cast<double>(out.count);
  out.least = histogram.quantile(0);
  for (int g = 0; g < kGreyValues; ++g) {
    const auto here = static_cast<double>(histogram.count[std::size_t(g)]);
    if (here == 0) continue;
    out.most = g;
    out.mean += g * (here / n);
    out.entropy_bit -= here / n * std::log2(here / n);
  }
  double squares = 0;
  for (int g = 0; g < kGreyValues; ++g)
    squares += static_cast<double>(histogram.count[std::size_t(g)]) * (g - out.mean) * (g - out.mean);
  if (out.count > 1) out.contrast = std::sqrt(squares / (n - 1));
  out.entropy_bit = std::max(0.0, out.entropy_bit);
  return out;
}

GreyTable identity_table() {
  return table_of([](int g) { return double(g); });
}

GreyTable chained(const GreyTable& first, const GreyTable& second) {
  GreyTable out{};
  for (std::size_t g = 0; g < kGreyValues; ++g) out[g] = second[first[g]];
  return out;
}

GreyTable stretch_table(int black, int white) {
  if (white <= black) return threshold_table(white);
  return table_of([&](int g) { return 255.0 * (g - black) / (white - black); });
}

GreyTable equalisation_table(const GreyHistogram& histogram) {
  if (histogram.total() == 0) return identity_table();
  return table_of([&](int g) { return 255 * histogram.share_up_to(g); });
}

GreyTable gamma_table(double gamma) {
  return table_of([&](int g) { return 255 * std::pow(g / 255.0, 1 / gamma); });
}

GreyTable negative_table() {
  return table_of([](int g) { return 255.0 - g; });
}

GreyTable threshold_table(int least) {
  return table_of([&](int g) { return g >= least ? 255.0 : 0.0; });
}

GreyTable slicing_table(int slices) {
  return table_of([&](int g) { return 255.0 * (g * slices / kGreyValues) / (slices - 1); });
}

std::optional<int> otsu_threshold(const GreyHistogram& histogram) {
  const GreyStatistics all = statistics_of(histogram);
  if (all.count == 0 || all.least == all.most) return std::nullopt;
  const auto n = static_cast<double>(all.count);
  double below = 0, below_sum = 0, best = -1;
  int first = 0, last = 0;
  for (int g = all.least + 1; g <= all.most; ++g) {  // bright from g on
    const double here = static_cast<double>(histogram.count[std::size_t(g - 1)]) / n;
    below += here;
    below_sum += here * (g - 1);
    const double apart = all.mean * below - below_sum, variance = apart * apart / (below * (1 - below));
    if (variance > best * (1 + 1e-12)) {
      best = variance;
      first = g;
    }
    if (variance >= best * (1 - 1e-12)) last = g;
  }
  return (first + last + 1) / 2;
}

std::array<Rgb, kGreyValues> palette_table(Palette palette) {
  const std::vector<Rgb> colours = colours_of(palette);
  std::array<Rgb, kGreyValues> out{};
  for (std::size_t g = 0; g < kGreyValues; ++g) {
    const double at = double(g) / (kGreyValues - 1) * double(colours.size() - 1);
    const std::size_t i = std::min(std::size_t(at), colours.size() - 2);
    for (std::size_t c = 0; c < 3; ++c)
      out[g][c] = static_cast<std::uint8_t>(
          std::lround(colours[i][c] + (at - double(i)) * (double(colours[i + 1][c]) - colours[i][c])));
  }
  return out;
}

}  // namespace collinea
