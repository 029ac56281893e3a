// SPDX-License-Identifier: Apache-2.0
#include "collinea/assess/internal/colour_errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace collinea {
namespace {

constexpr int kStrip = 128;        // rows
constexpr int kAround = 2;         // [px] in which a true colour may lie
constexpr double kTolerance = 25;  // [grey levels]
constexpr int kStride = 4;         // of the pixels that tell an image's brightness
constexpr double kDarkest = 10, kBrightest = 245;
constexpr std::size_t kFewest = 500;  // pixels that tell it

// Ratios in steps of 0.2 % between 1/e and e; the median of a channel of an image.
struct Histogram {
  static constexpr int kBins = 1000;
  std::array<std::uint32_t, kBins> counts{};
  std::size_t total = 0;

  void add(double log_ratio) {
    ++counts[std::size_t(std::clamp(int((log_ratio + 1) / 2 * kBins), 0, kBins - 1))];
    ++total;
  }
  [[nodiscard]] double median() const {
    std::size_t below = 0;
    int bin = 0;
    while (2 * (below + counts[std::size_t(bin)]) < total) below += counts[std::size_t(bin++)];
    const double inside = (double(total) / 2 - double(below)) / counts[std::size_t(bin)];
    return 2 * (bin + inside) / kBins - 1;
  }
};
using Gains = std::map<int, std::array<Histogram, 3>>;

// A strip of the product, and of the truth as much as lies under and around it.
struct Strip {
  int row = 0;
  Raster<std::uint8_t> product, truth;
  FloatImage sources;
  int truth_left = 0, truth_top = 0;
};

class Comparison {
 public:
  Comparison(const ImageField& product, const SourceReader& sources, const ImageField& truth)
      : product_(product), sources_(sources), truth_(truth) {}

  template <class Visit>
  Result<> each_strip(const Run& run, Visit&& visit) const {
    for (int row = 0; row < product_.grid.height; row += kStrip) {
      if (run.stopped()) return fail(Errc::kCancelled, "cancelled");
      Strip strip;
      strip.row = row;
      const int height = std::min(kStrip, product_.grid.height - row), width = product_.grid.width;
      const int left = std::clamp(int(truth_x(0)) - 4, 0, truth_.grid.width);
      const int right = std::clamp(int(truth_x(width)) + 5, 0, truth_.grid.width);
      const int top = std::clamp(int(truth_y(row)) - 4, 0, truth_.grid.height);
      const int bottom = std::clamp(int(truth_y(row + height)) + 5, 0, truth_.grid.height);
      if (right <= left || bottom <= top) continue;
      strip.truth_left = left, strip.truth_top = top;
      COLLINEA_TRY(strip.product, product_.read(0, row, width, height));
      COLLINEA_TRY(strip.truth, truth_.read(left, top, right - left, bottom - top));
      if (strip.product.channels < 3 || strip.truth.channels < 3)
        return fail(Errc::kBadInput, "the orthophoto or the true one has no colours");
      if (sources_) {
        COLLINEA_TRY(strip.sources, sources_(0, row, width, height));
      }
      visit(strip);
    }
    return {};
  }

  // The true pixel under one of the product, in the strip's window; false where it and those around are not all known.
  [[nodiscard]] bool locate(const Strip& strip, int x, int y, int& u, int& v) const {
    if (strip.product.channels == 4 && strip.product.at(x, y, 3) == 0) return false;
    u = int(std::floor(truth_x(x + 0.5))) - strip.truth_left,
    v = int(std::floor(truth_y(strip.row + y + 0.5))) - strip.truth_top;
    if (u < kAround || v < kAround || u + kAround >= strip.truth.width || v + kAround >= strip.truth.height)
      return false;
    if (strip.truth.channels < 4) return true;
    for (int j = v - kAround; j <= v + kAround; ++j)
      for (int i = u - kAround; i <= u + kAround; ++i)
        if (strip.truth.at(i, j, 3) == 0) return false;
    return true;
  }

 private:
  [[nodiscard]] double truth_x(double column) const { return truth_.grid.column_of(product_.grid.east_of(column)); }
  [[nodiscard]] double truth_y(double row) const { return truth_.grid.row_of(product_.grid.north_of(row)); }

  const ImageField& product_;
  const SourceReader& sources_;
  const ImageField& truth_;
};

void add_gains(const Comparison& comparison, const Strip& strip, Gains& gains) {
  for (int y = 0; y < strip.product.height; y += kStride) {
    for (int x = 0; x < strip.product.width; x += kStride) {
      int u = 0, v = 0;
      if (!comparison.locate(strip, x, y, u, v)) continue;
      auto& histograms = gains[strip.sources.empty() ? 0 : int(strip.sources.at(x, y))];
      for (int c = 0; c < 3; ++c) {
        const double made = strip.product.at(x, y, c), expected = strip.truth.at(u, v, c);
        if (made >= kDarkest && made <= kBrightest && expected >= kDarkest && expected <= kBrightest)
          histograms[std::size_t(c)].add(std::log(made / expected));
      }
    }
  }
}

// Fills in the figures of the gains; returns the logarithms of what they have in common.
std::array<double, 3> common_gain(const Gains& gains, ColourErrors& errors) {
  std::array<double, 3> common{};
  std::vector<std::array<double, 3>> medians;
  for (const auto& [source, histograms] : gains) {
    if (std::any_of(histograms.begin(), histograms.end(), [](const Histogram& h) { return h.total < kFewest; }))
      continue;
    medians.push_back({histograms[0].median(), histograms[1].median(), histograms[2].median()});
    for (std::size_t c = 0; c < 3; ++c) common[c] += medians.back()[c];
  }
  errors.images = medians.size();
  if (medians.empty()) return common;
  for (double& gain : common) gain /= double(medians.size());
  for (const auto& gain : medians) {
    for (std::size_t c = 0; c < 3; ++c) {
      errors.gain_rms += (gain[c] - common[c]) * (gain[c] - common[c]) / 3;
      errors.gain_worst = std::max(errors.gain_worst, std::abs(gain[c] - common[c]));
    }
  }
  errors.gain_rms = std::sqrt(errors.gain_rms / double(medians.size()));
  return common;
}

void add_pixels(const Comparison& comparison, const Strip& strip, const std::array<double, 3>& common,
                ColourErrors& errors) {
  std::array<double, 3> factor;
  for (std::size_t c = 0; c < 3; ++c) factor[c] = std::exp(-common[c]);
  for (int y = 0; y < strip.product.height; ++y) {
    for (int x = 0; x < strip.product.width; ++x) {
      int u = 0, v = 0;
      if (!comparison.locate(strip, x, y, u, v)) continue;
      bool wrong = false;
      for (int c = 0; c < 3; ++c) {
        const double made = factor[std::size_t(c)] * strip.product.at(x, y, c);
        int low = 255, high = 0;
        for (int j = v - kAround; j <= v + kAround; ++j)
          for (int i = u - kAround; i <= u + kAround; ++i)
            low = std::min<int>(low, strip.truth.at(i, j, c)), high = std::max<int>(high, strip.truth.at(i, j, c));
        wrong |= made < low - kTolerance || made > high + kTolerance;
        errors.rms_grey += (made - strip.truth.at(u, v, c)) * (made - strip.truth.at(u, v, c)) / 3;
      }
      ++errors.pixels;
      errors.share_wrong += wrong;
    }
  }
}

}  // namespace

Result<ColourErrors> colour_errors(const ImageField& product, const SourceReader& sources, const ImageField& truth,
                                   const Run& run) {
  const Comparison comparison(product, sources, truth);
  ColourErrors errors;
  Gains gains;
  auto looked = comparison.each_strip(run, [&](const Strip& strip) { add_gains(comparison, strip, gains); });
  if (!looked) return tl::unexpected(std::move(looked).error());
  const std::array<double, 3> common = common_gain(gains, errors);
  looked = comparison.each_strip(run, [&](const Strip& strip) { add_pixels(comparison, strip, common, errors); });
  if (!looked) return tl::unexpected(std::move(looked).error());
  if (errors.pixels == 0) return fail(Errc::kBadInput, "the orthophoto and the true one have no area in common");
  errors.share_wrong /= double(errors.pixels);
  errors.rms_grey = std::sqrt(errors.rms_grey / double(errors.pixels));
  return errors;
}

}  // namespace collinea
