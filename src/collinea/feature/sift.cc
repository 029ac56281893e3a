// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/sift.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "collinea/feature/internal/describe.h"
#include "collinea/feature/internal/extrema.h"
#include "collinea/feature/internal/scale_space.h"
#include "collinea/feature/internal/spread.h"
#include "collinea/feature/internal/strongest_first.h"

namespace collinea {
namespace {

constexpr int kLeastSize_px = 16;
constexpr double kUpsampleBelow_px2 = 2.5e6;
constexpr double kDirectionsPerSite = 1.17;  // on an average

// The levels that features are described on; the others are needed for detection only.
struct DescribingLevels {
  std::array<Plane, kSteps + 1> planes;  // 1 to kSteps
  double pixel_px;                       // size of the octave's pixel in pixels of the image
  double origin_px;                      // x and y of its first pixel's centre in the image
};

struct Candidate {
  Extremum extremum;
  std::uint32_t octave;
};

struct Oriented {
  std::uint32_t candidate;
  float angle_rad, strength;
};

struct Detection {
  std::vector<DescribingLevels> octaves;
  std::vector<Candidate> candidates;
};

Detection detect(const GreyImage& image, const SiftOptions& options, bool upsample) {
  Detection detection;
  Plane level0 = first_level(image, upsample);
  for (double pixel_px = upsample ? 0.5 : 1;; pixel_px *= 2) {
    Octave octave = octave_from(std::move(level0));
    const auto index = static_cast<std::uint32_t>(detection.octaves.size());
    for (const Extremum& extremum : find_extrema(octave, options.peak_threshold, options.edge_ratio))
      detection.candidates.push_back({extremum, index});
    level0 = next_level0(octave);
    DescribingLevels& kept = detection.octaves.emplace_back();
    kept.pixel_px = pixel_px;
    kept.origin_px = upsample ? 0.25 : 0.5;  // the first pixel of every octave is that of the first octave
    for (std::size_t level = 1; level <= kSteps; ++level) kept.planes[level] = std::move(octave[level]);
    if (std::min(level0.width(), level0.height()) < kLeastSize_px) return detection;
  }
}

// A candidate with the plane it is described on.
struct Site {
  const Candidate& candidate;
  const DescribingLevels& octave;
  const Plane& plane;
  double blur_px;  // in pixels of the octave

  Site(const Detection& detection, std::uint32_t index)
      : candidate(detection.candidates[index]),
        octave(detection.octaves[candidate.octave]),
        plane(octave.planes[static_cast<std::size_t>(
            std::clamp(static_cast<int>(std::lround(candidate.extremum.level)), 1, kSteps))]),
        blur_px(blur_of_level(candidate.extremum.level)) {}
};

Keypoint keypoint(const Site& site, float angle_rad, float strength) {
  const Extremum& extremum = site.candidate.extremum;
  const double scale = site.octave.pixel_px;
  return {.x = static_cast<float>(site.octave.origin_px + extremum.x * scale),
          .y = static_cast<float>(site.octave.origin_px + extremum.y * scale),
          .scale_px = static_cast<float>(site.blur_px * scale),
          .angle_rad = angle_rad,
          .strength = strength};
}

// The candidates with their directions, strongest first, as many features as wanted.
std::vector<Oriented> choose(const Detection& detection, const GreyImage& image, const SiftOptions& options) {
  std::vector<Spot> spots;
  spots.reserve(detection.candidates.size());
  for (std::uint32_t i = 0; i < detection.candidates.size(); ++i) {
    const float strength = detection.candidates[i].extremum.strength;
    const Keypoint located = keypoint(Site(detection, i), 0, strength);
    spots.push_back({located.x, located.y, strength});
  }
  const auto most = static_cast<std::size_t>(std::max(0, options.max_features));
  const int sites = static_cast<int>(std::lround(options.max_features / kDirectionsPerSite));
  const std::vector<float> strengths = regional_strengths(spots, image.width, image.height, sites, options.evenness);
  std::vector<std::uint32_t> order(spots.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t i) { return strengths[i]; });
  if (order.size() > most) order.resize(most);

  // Neighbours are looked at one after the other: their pixels are still in the cache.
  std::vector<std::uint32_t> by_index = order;
  std::ranges::sort(by_index);
  std::vector<MainDirections> directions(detection.candidates.size());
  for (const std::uint32_t i : by_index) {
    const Site site(detection, i);
    directions[i] =
        main_directions(site.plane.view(), site.candidate.extremum.x, site.candidate.extremum.y, site.blur_px);
  }
  std::vector<Oriented> chosen;
  for (const std::uint32_t i : order)
    for (std::size_t k = 0; k < directions[i].count && chosen.size() < most; ++k)
      chosen.push_back({i, directions[i].angle_rad[k], strengths[i]});
  return chosen;
}

Features described(const Detection& detection, std::vector<Oriented> chosen) {
  // In the order of octave, level, row and column: neighbours are described one after the other.
  std::ranges::stable_sort(chosen, {}, &Oriented::candidate);
  Features features;
  for (const Oriented& one : chosen) {
    const Site site(detection, one.candidate);
    const Extremum& extremum = site.candidate.extremum;
    features.keypoints.push_back(keypoint(site, one.angle_rad, one.strength));
    features.descriptors.push_back(
        describe_patch(site.plane.view(), extremum.x, extremum.y, site.blur_px, one.angle_rad));
  }
  return features;
}

}  // namespace

Features detect_sift(const GreyImage& image, const SiftOptions& options) {
  if (std::min(image.width, image.height) < kLeastSize_px) return {};
  const bool upsample = options.upsample.value_or(double(image.width) * image.height < kUpsampleBelow_px2);
  const Detection detection = detect(image, options, upsample);
  return strongest_first(described(detection, choose(detection, image, options)));
}

}  // namespace collinea
