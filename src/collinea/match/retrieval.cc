// SPDX-License-Identifier: Apache-2.0
#include "collinea/match/retrieval.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "collinea/base/parallel.h"
#include "collinea/match/internal/descriptors_kernels.h"
#include "collinea/math/random.h"

namespace collinea {
namespace {

constexpr std::size_t kWords = 32;
constexpr std::size_t kLength = kWords * sizeof(Descriptor);
constexpr std::size_t kSample = 32768;  // descriptors: a thousand a word fix it well
constexpr int kRounds = 10;             // of k-means: the words hardly move after these
constexpr double kFullScale = 16;       // bytes a standard deviation of a component: the range is eight of them

using Words = std::vector<Descriptor>;
using Signature = std::span<std::int8_t>;  // kLength, zeros at first

std::vector<Descriptor> sample_of(const std::map<ImageId, Glance>& glances, std::uint64_t seed) {
  std::size_t total = 0;
  for (const auto& [id, glance] : glances) total += glance.descriptors.size();
  std::vector<Descriptor> sample;
  Random random(seed, 0x766c6164);
  for (const auto& [id, glance] : glances)
    for (const Descriptor& descriptor : glance.descriptors)
      if (random.uniform() * static_cast<double>(total) < static_cast<double>(kSample)) sample.push_back(descriptor);
  return sample;
}

std::vector<std::uint32_t> nearest_words(const std::vector<Descriptor>& descriptors, const Words& words) {
  std::vector<NearestTwo> of_descriptor(descriptors.size()), of_word(words.size());
  nearest_two(descriptors.front().data(), descriptors.size(), words.front().data(), words.size(), of_descriptor.data(),
              of_word.data());
  std::vector<std::uint32_t> nearest;
  for (const NearestTwo& two : of_descriptor) nearest.push_back(two.index);
  return nearest;
}

// Lloyd's k-means from a random start; a word without descriptors stays.
Words words_of(const std::vector<Descriptor>& sample, std::uint64_t seed) {
  Words words;
  Random random(seed, 0x776f7264);
  for (std::size_t i = 0; i < kWords; ++i)
    words.push_back(sample[random.below(static_cast<std::uint32_t>(sample.size()))]);
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<std::uint32_t> nearest = nearest_words(sample, words);
    std::vector<std::array<std::uint64_t, sizeof(Descriptor)>> sums(kWords);
    std::vector<std::uint64_t> counts(kWords);
    for (std::size_t i = 0; i < sample.size(); ++i) {
      ++counts[nearest[i]];
      for (std::size_t k = 0; k < sizeof(Descriptor); ++k) sums[nearest[i]][k] += sample[i][k];
    }
    for (std::size_t word = 0; word < kWords; ++word)
      for (std::size_t k = 0; counts[word] > 0 && k < sizeof(Descriptor); ++k)
        words[word][k] = static_cast<std::uint8_t>((sums[word][k] + counts[word] / 2) / counts[word]);
  }
  return words;
}

// Every word's part of the vector, of unit length, in bytes. One component of 128 has a standard deviation of 1/11.
void write_signature(const Glance& glance, const Words& words, Signature signature) {
  if (glance.descriptors.empty()) return;
  std::vector<std::array<int, sizeof(Descriptor)>> residuals(kWords);
  const std::vector<std::uint32_t> nearest = nearest_words(glance.descriptors, words);
  for (std::size_t i = 0; i < nearest.size(); ++i)
    for (std::size_t k = 0; k < sizeof(Descriptor); ++k)
      residuals[nearest[i]][k] += int(glance.descriptors[i][k]) - int(words[nearest[i]][k]);
  for (std::size_t word = 0; word < kWords; ++word) {
    double squared = 0;
    for (const int value : residuals[word]) squared += double(value) * value;
    const double scale = squared > 0 ? kFullScale * std::sqrt(double(sizeof(Descriptor)) / squared) : 0;
    for (std::size_t k = 0; k < sizeof(Descriptor); ++k)
      signature[word * sizeof(Descriptor) + k] =
          static_cast<std::int8_t>(std::clamp(std::lround(residuals[word][k] * scale), -127l, 127l));
  }
}

}  // namespace

Result<std::vector<ImageIdPair>> similar_pairs(const std::map<ImageId, Glance>& glances, const PairOptions& options,
                                               const Run& run) {
  std::vector<ImageId> images;
  for (const auto& [id, glance] : glances) images.push_back(id);
  const std::size_t count =
      std::min(static_cast<std::size_t>(options.candidates), images.empty() ? 0 : images.size() - 1);
  std::vector<std::int8_t> signatures(images.size() * kLength);
  const std::vector<Descriptor> sample = sample_of(glances, run.seed);
  if (!sample.empty() && count + 1 < images.size()) {
    const Words words = words_of(sample, run.seed);
    parallel_for(run, images.size(), [&](std::size_t i) {
      write_signature(glances.at(images[i]), words, std::span(signatures).subspan(i * kLength, kLength));
    });
  }

  std::vector<std::vector<ImageIdPair>> found(images.size());
  parallel_for(run, images.size(), [&](std::size_t i) {
    std::vector<std::int32_t> similarities(images.size());
    dot_products(&signatures[i * kLength], signatures.data(), kLength, images.size(), similarities.data());
    std::vector<std::pair<int, std::size_t>> others;  // the most similar first
    for (std::size_t j = 0; j < images.size(); ++j)
      if (j != i) others.emplace_back(-similarities[j], j);
    std::ranges::partial_sort(others, others.begin() + static_cast<std::ptrdiff_t>(count));
    for (std::size_t k = 0; k < count; ++k) found[i].emplace_back(std::minmax(images[i], images[others[k].second]));
  });
  if (run.stopped()) return fail(Errc::kCancelled, "stopped while looking for similar images");
  std::vector<ImageIdPair> pairs;
  for (const auto& some : found) pairs.insert(pairs.end(), some.begin(), some.end());
  std::ranges::sort(pairs);
  pairs.erase(std::ranges::unique(pairs).begin(), pairs.end());
  return pairs;
}

}  // namespace collinea
