// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/sift.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "collinea/feature/internal/describe.h"
#include "collinea/feature/internal/extrema.h"
#include "collinea/feature/internal/octave_rows.h"
#include "collinea/feature/internal/spread.h"
#include "collinea/feature/internal/strongest_first.h"

namespace collinea {
namespace {

constexpr int kLeastSize_px = 16;
constexpr double kUpsampleBelow_px2 = 2.5e6;
constexpr double kDirectionsPerSite = 1.17;  // on an average
// Rows that the description of a position looks at on both sides: the half diagonal of the largest patch (describe.h),
// 1.5 times 2.5 cells of 3 blurs, turned by 45 degrees, of the coarsest level, and a row for gradients.
constexpr int kDescribingReach = 60;

// An octave as features are described on it: its levels 1 to kSteps, or where they are large what they are made from.
struct DescribingOctave {
  int width, height;
  double pixel_px;   // size of the octave's pixel in pixels of the image
  double origin_px;  // x and y of its first pixel's centre in the image
  Plane level0;      // empty: that of the image, or levels are kept
  std::optional<Octave> levels;
};

struct Candidate {
  Extremum extremum;
  std::uint32_t octave;

  [[nodiscard]] std::size_t level() const {
    return static_cast<std::size_t>(std::clamp(static_cast<int>(std::lround(extremum.level)), 1, kSteps));
  }
  [[nodiscard]] double blur_px() const { return blur_of_level(extremum.level); }  // in pixels of the octave
};

struct Oriented {
  std::uint32_t candidate;
  float angle_rad, strength;
};

bool is_upsampled(int width, int height, const SiftOptions& options) {
  return options.upsample.value_or(double(width) * height < kUpsampleBelow_px2);
}

RowSource rows_of(const Plane& plane) {
  return [&plane](int y, float* row) { std::copy_n(plane.row(y), plane.width(), row); };
}

class Detection {
 public:
  Detection(const GreyImage& image, const SiftOptions& options, bool upsample, std::size_t most_kept_bytes)
      : image_(image), upsample_(upsample) {
    Plane level0;  // of the first octave: row by row from the image
    double pixel_px = upsample ? 0.5 : 1;
    for (int width = image.width * (upsample ? 2 : 1), height = image.height * (upsample ? 2 : 1);; pixel_px *= 2) {
      // The first pixel of every octave is that of the first octave.
      octaves_.push_back({width, height, pixel_px, upsample ? 0.25 : 0.5, std::move(level0), {}});
      level0 = look_through(options, most_kept_bytes);
      width = level0.width(), height = level0.height();
      if (std::min(width, height) < kLeastSize_px) return;
    }
  }

  [[nodiscard]] const std::vector<Candidate>& candidates() const { return candidates_; }

  [[nodiscard]] Keypoint keypoint(std::uint32_t candidate, float angle_rad, float strength) const {
    const Extremum& extremum = candidates_[candidate].extremum;
    const DescribingOctave& octave = octaves_[candidates_[candidate].octave];
    return {.x = static_cast<float>(octave.origin_px + extremum.x * octave.pixel_px),
            .y = static_cast<float>(octave.origin_px + extremum.y * octave.pixel_px),
            .scale_px = static_cast<float>(candidates_[candidate].blur_px() * octave.pixel_px),
            .angle_rad = angle_rad,
            .strength = strength};
  }

  // Calls look(candidate, image) for some of the candidates, in ascending order, with the level they are described on.
  template <class Look>
  void describe(std::vector<std::uint32_t> some, const Look& look) const {
    std::ranges::sort(some);  // neighbours one after the other: their pixels are still in the cache
    auto begin = some.begin();
    for (std::uint32_t i = 0; i < octaves_.size(); ++i) {
      const auto end = std::find_if(begin, some.end(), [&](std::uint32_t c) { return candidates_[c].octave != i; });
      describe_in(octaves_[i], {begin, end}, look);
      begin = end;
    }
  }

 private:
  [[nodiscard]] RowSource level0_of(const DescribingOctave& octave) const {
    return octave.level0.empty() ? first_level_rows(image_, upsample_) : rows_of(octave.level0);
  }

  // Finds the candidates of the last octave; answers level 0 of the next one, every second pixel of every second row,
  // from the first on, of level kSteps.
  Plane look_through(const SiftOptions& options, std::size_t most_kept_bytes) {
    DescribingOctave& octave = octaves_.back();
    const auto pixels = static_cast<std::size_t>(octave.width) * static_cast<std::size_t>(octave.height);
    const bool are_kept = pixels * kSteps * sizeof(float) <= most_kept_bytes;
    OctaveRows rows(octave.width, octave.height, level0_of(octave),
                    {.reach = ExtremumSearch::kReach, .are_kept = are_kept});
    ExtremumSearch search(options.peak_threshold, options.edge_ratio);
    Plane next((octave.width + 1) / 2, (octave.height + 1) / 2);
    for (int y = 0; rows.next();) {
      search.look(rows.levels(), rows.begin(), rows.end());
      for (; 2 * y < rows.end(); ++y) {
        const float* in = rows.levels()[kSteps].row(2 * y);
        float* out = next.row(y);
        for (int x = 0; x < next.width(); ++x) out[x] = in[2 * x];
      }
    }
    const auto index = static_cast<std::uint32_t>(octaves_.size() - 1);
    for (const Extremum& extremum : std::move(search).found()) candidates_.push_back({extremum, index});
    if (are_kept) {
      octave.levels = std::move(rows).take_levels();
      for (const std::size_t unused : {0, kSteps + 1, kSteps + 2}) (*octave.levels)[unused] = {};
      octave.level0 = {};
    }
    return next;
  }

  template <class Look>
  void describe_in(const DescribingOctave& octave, std::vector<std::uint32_t> some, const Look& look) const {
    if (octave.levels) {
      for (const std::uint32_t i : some) look(i, (*octave.levels)[candidates_[i].level()].view());
      return;
    }
    if (some.empty()) return;
    std::ranges::stable_sort(some, {}, [&](std::uint32_t i) { return candidates_[i].extremum.y; });
    OctaveRows rows(octave.width, octave.height, level0_of(octave), {.reach = kDescribingReach, .levels = kSteps + 1});
    for (auto next = some.begin(); next != some.end() && rows.next();)
      for (; next != some.end() && candidates_[*next].extremum.y < float(rows.end()); ++next)
        look(*next, rows.levels()[candidates_[*next].level()].view());
  }

  const GreyImage& image_;
  bool upsample_;
  std::vector<DescribingOctave> octaves_;
  std::vector<Candidate> candidates_;
};

// The candidates with their directions, strongest first, as many features as wanted.
std::vector<Oriented> choose(const Detection& detection, const GreyImage& image, const SiftOptions& options) {
  const std::vector<Candidate>& candidates = detection.candidates();
  std::vector<Spot> spots;
  spots.reserve(candidates.size());
  for (std::uint32_t i = 0; i < candidates.size(); ++i) {
    const float strength = candidates[i].extremum.strength;
    const Keypoint located = detection.keypoint(i, 0, strength);
    spots.push_back({located.x, located.y, strength});
  }
  const auto most = static_cast<std::size_t>(std::max(0, options.max_features));
  const int sites = static_cast<int>(std::lround(options.max_features / kDirectionsPerSite));
  const std::vector<float> strengths = regional_strengths(spots, image.width, image.height, sites, options.evenness);
  std::vector<std::uint32_t> order(spots.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::stable_sort(order, std::ranges::greater{}, [&](std::uint32_t i) { return strengths[i]; });
  if (order.size() > most) order.resize(most);

  std::vector<MainDirections> directions(candidates.size());
  detection.describe(order, [&](std::uint32_t i, const BlurredImage& level) {
    const Extremum& extremum = candidates[i].extremum;
    directions[i] = main_directions(level, extremum.x, extremum.y, candidates[i].blur_px());
  });
  std::vector<Oriented> chosen;
  for (const std::uint32_t i : order)
    for (std::size_t k = 0; k < directions[i].count && chosen.size() < most; ++k)
      chosen.push_back({i, directions[i].angle_rad[k], strengths[i]});
  return chosen;
}

// In the order of the candidates: of octave, level, row and column.
Features described(const Detection& detection, std::vector<Oriented> chosen) {
  std::ranges::stable_sort(chosen, {}, &Oriented::candidate);
  Features features;
  for (const Oriented& one : chosen)
    features.keypoints.push_back(detection.keypoint(one.candidate, one.angle_rad, one.strength));
  features.descriptors.resize(chosen.size());
  std::vector<std::uint32_t> sites;
  for (const Oriented& one : chosen)
    if (sites.empty() || sites.back() != one.candidate) sites.push_back(one.candidate);
  detection.describe(sites, [&](std::uint32_t i, const BlurredImage& level) {
    const Candidate& at = detection.candidates()[i];
    const auto of_it = std::ranges::equal_range(chosen, i, {}, &Oriented::candidate);
    for (auto one = of_it.begin(); one != of_it.end(); ++one)
      features.descriptors[static_cast<std::size_t>(one - chosen.begin())] =
          describe_patch(level, at.extremum.x, at.extremum.y, at.blur_px(), one->angle_rad);
  });
  return features;
}

}  // namespace

std::size_t bytes_to_detect_sift(int width, int height, const SiftOptions& options) {
  constexpr double kHeldRows = 1800;  // of all levels of a band
  const double finest = is_upsampled(width, height, options) ? 2 : 1;
  double bytes = double(width) * height + finest * width * kHeldRows * sizeof(float);
  bool is_first = true;
  for (double pixels = finest * width * finest * height; pixels > 1; pixels /= 4) {
    const double levels = pixels * kSteps * sizeof(float);
    const bool are_kept = levels <= kMostKeptBytes;
    if (are_kept) bytes += levels;
    if (!are_kept && !is_first) bytes += pixels * sizeof(float);  // what the levels are made from
    is_first = false;
  }
  return static_cast<std::size_t>(bytes);
}

Features detect_sift(const GreyImage& image, const SiftOptions& options, std::size_t most_kept_bytes) {
  if (std::min(image.width, image.height) < kLeastSize_px) return {};
  const Detection detection(image, options, is_upsampled(image.width, image.height, options), most_kept_bytes);
  return strongest_first(described(detection, choose(detection, image, options)));
}

}  // namespace collinea
