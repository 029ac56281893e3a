// SPDX-License-Identifier: Apache-2.0
#include <cmath>

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

Raster<std::uint8_t> eight_bits(Samples samples) {
  if (samples.words.empty()) return std::move(samples.bytes);
  const Raster<std::uint16_t>& words = samples.words;
  std::vector<std::uint64_t> histogram(65536);
  for (const std::uint16_t word : words.data) ++histogram[word];
  const int low = percentile(histogram, words.data.size(), 0.001);
  const int high = std::max(low + 1, percentile(histogram, words.data.size(), 0.999));

  std::vector<std::uint8_t> scaled(65536);
  for (int value = 0; value < 65536; ++value)
    scaled[std::size_t(value)] = std::uint8_t(std::lround(255.0 * (std::clamp(value, low, high) - low) / (high - low)));
  Raster<std::uint8_t> bytes(words.width, words.height, words.channels);
  for (std::size_t i = 0; i < words.data.size(); ++i) bytes.data[i] = scaled[words.data[i]];
  return bytes;
}

Raster<std::uint8_t> with_channels(Raster<std::uint8_t> image, int channels) {
  if (image.channels == channels) return image;
  const std::size_t count = std::size_t(image.width) * std::size_t(image.height);
  Raster<std::uint8_t> changed(image.width, image.height, channels);
  if (channels == 1) {
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint8_t* rgb = &image.data[3 * i];
      changed.data[i] = std::uint8_t((19595u * rgb[0] + 38470u * rgb[1] + 7471u * rgb[2] + 32768u) >> 16);
    }
  } else {
    for (std::size_t i = 0; i < count; ++i)
      changed.data[3 * i] = changed.data[3 * i + 1] = changed.data[3 * i + 2] = image.data[i];
  }
  return changed;
}

}  // namespace collinea
