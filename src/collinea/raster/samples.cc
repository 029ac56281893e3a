// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <numeric>

#include "collinea/raster/codec.h"

namespace collinea {
namespace {

// The value below which `share` of the samples lie.
int percentile(const std::vector<std::uint64_t>& histogram, std::uint64_t count, double share) {
  const auto wanted = std::uint64_t(share * double(count));
  std::uint64_t below = 0;
  for (std::size_t value = 0; value < histogram.size(); ++value) {
    below += histogram[value];
    if (below > wanted) return int(value);
  }
  return int(histogram.size()) - 1;
}

}  // namespace

void EightBitImage::begin(const SampleFormat& format) {
  format_ = format;
  if (format.is_deep && scaled_.empty())
    histogram_.assign(65536, 0);
  else
    image_ = Raster<std::uint8_t>(format.width, format.height, channels_);
}

void EightBitImage::take(const SamplePiece& piece) {
  if (!format_.is_deep) return convert<std::uint8_t>(piece, [](std::uint8_t sample) { return sample; });
  if (!scaled_.empty()) return convert<std::uint16_t>(piece, [&](std::uint16_t sample) { return scaled_[sample]; });
  for (int y = 0; y < piece.height; ++y) {
    const auto* pixel = static_cast<const std::uint16_t*>(piece.samples) +
                        std::size_t(y) * std::size_t(piece.row_px) * std::size_t(piece.samples_of_px);
    for (int x = 0; x < piece.width; ++x, pixel += piece.samples_of_px)
      for (int c = 0; c < format_.channels; ++c) ++histogram_[pixel[c]];
  }
}

bool EightBitImage::wants_more() {
  if (!format_.is_deep || !scaled_.empty()) return false;
  const auto count = std::accumulate(histogram_.begin(), histogram_.end(), std::uint64_t{0});
  const int low = percentile(histogram_, count, 0.001);
  const int high = std::max(low + 1, percentile(histogram_, count, 0.999));
  scaled_.resize(65536);
  for (int value = 0; value < 65536; ++value)
    scaled_[std::size_t(value)] =
        std::uint8_t(std::lround(255.0 * (std::clamp(value, low, high) - low) / (high - low)));
  return true;
}

template <class T, class Grey>
void EightBitImage::convert(const SamplePiece& piece, const Grey& grey) {
  const int from = format_.channels;
  for (int y = 0; y < piece.height; ++y) {
    const T* pixel = static_cast<const T*>(piece.samples) +
                     std::size_t(y) * std::size_t(piece.row_px) * std::size_t(piece.samples_of_px);
    std::uint8_t* out = image_.row(piece.top + y) + std::size_t(piece.left) * std::size_t(channels_);
    for (int x = 0; x < piece.width; ++x, pixel += piece.samples_of_px, out += channels_) {
      if (from == channels_) {
        for (int c = 0; c < from; ++c) out[c] = grey(pixel[c]);
      } else if (from == 3) {
        const unsigned red = grey(pixel[0]), green = grey(pixel[1]), blue = grey(pixel[2]);
        out[0] = std::uint8_t((19595u * red + 38470u * green + 7471u * blue + 32768u) >> 16);
      } else {
        out[0] = out[1] = out[2] = grey(pixel[0]);
      }
    }
  }
}

Raster<std::uint8_t> with_channels(Raster<std::uint8_t> image, int channels) {
  if (image.channels == channels) return image;
  EightBitImage changed(channels);
  changed.begin({.width = image.width, .height = image.height, .channels = image.channels});
  changed.take({.width = image.width,
                .height = image.height,
                .samples = image.data.data(),
                .row_px = image.width,
                .samples_of_px = image.channels});
  return std::move(changed).image();
}

}  // namespace collinea
