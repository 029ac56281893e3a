// SPDX-License-Identifier: Apache-2.0
#include "collinea/feature/detect.h"

#include <algorithm>
#include <cmath>

#include "collinea/feature/interest.h"
#include "collinea/feature/internal/describe.h"
#include "collinea/feature/internal/scale_space.h"
#include "collinea/feature/internal/spread.h"
#include "collinea/feature/internal/strongest_first.h"
#include "collinea/raster/pyramid.h"

namespace collinea {
namespace {

constexpr int kLeastLevel_px = 32;
constexpr double kDescribingLevel = 2;  // of SIFT's octave: a blur of 2.54 px
constexpr double kGreyRange = 255;
constexpr double kOfFirstLevel = 0.75;  // 1 + 1/4 + 1/16 ... = 1 / 0.75

InterestOperator operator_of(Detector detector) {
  return detector == Detector::kHarris ? InterestOperator::kHarris : InterestOperator::kFoerstner;
}

InterestOptions corner_options(const DetectOptions& o, int most) {
  InterestOptions corners;
  corners.method = operator_of(o.detector);
  corners.max_points = most;
  corners.evenness = o.sift.evenness;
  corners.threshold = std::pow(kGreyRange * o.sift.peak_threshold, 1 / contrast_power(corners.method));
  corners.noise_grey = 1;  // positions do not depend on it, and covariances are not kept
  return corners;
}

// The corners of one level, described, in pixels of the image.
void append_level(const GreyImage& image, const DetectOptions& o, int level, int most, Features& features) {
  const InterestPoints found = find_interest_points(image, corner_options(o, most));
  const double blur_px = blur_of_level(kDescribingLevel), pixel_px = std::ldexp(1.0, level);
  const Plane plane = blurred(first_level(image, false), std::sqrt(blur_px * blur_px - kFirstBlur_px * kFirstBlur_px));
  const std::size_t enough = features.keypoints.size() + static_cast<std::size_t>(most);
  for (const InterestPoint& p : found.points) {
    const auto x = static_cast<float>(p.position_px.x() - 0.5), y = static_cast<float>(p.position_px.y() - 0.5);
    const MainDirections directions = main_directions(plane.view(), x, y, blur_px);
    for (std::size_t k = 0; k < directions.count && features.keypoints.size() < enough; ++k) {
      features.keypoints.push_back(
          {.x = static_cast<float>(p.position_px.x() * pixel_px),
           .y = static_cast<float>(p.position_px.y() * pixel_px),
           .scale_px = static_cast<float>(blur_px * pixel_px),
           .angle_rad = directions.angle_rad[k],
           .strength = static_cast<float>(std::pow(p.strength, contrast_power(operator_of(o.detector))))});
      features.descriptors.push_back(describe_patch(plane.view(), x, y, blur_px, directions.angle_rad[k]));
    }
  }
}

std::vector<GreyImage> pyramid_of(const GreyImage& image, int levels) {
  std::vector<GreyImage> out = {image};
  while (static_cast<int>(out.size()) < levels && std::min(out.back().width, out.back().height) >= 2 * kLeastLevel_px)
    out.push_back(half(out.back()));
  return out;
}

Features corners(const GreyImage& image, const DetectOptions& o) {
  const std::vector<GreyImage> levels = pyramid_of(image, o.corner_levels);
  Features found;
  for (int level = static_cast<int>(levels.size()) - 1; level >= 0; --level) {
    const int left = o.sift.max_features - static_cast<int>(found.keypoints.size());
    const double share = kOfFirstLevel * std::ldexp(o.sift.max_features, -2 * level);
    append_level(levels[static_cast<std::size_t>(level)], o, level,
                 level == 0 ? left : std::min(left, static_cast<int>(std::ceil(share))), found);
  }
  return found;
}

// Strengths in part beside those of the region, as with SIFT: what is matched first is spread over the image.
void spread(Features& features, const GreyImage& image, const DetectOptions& o) {
  std::vector<Spot> spots;
  for (const Keypoint& k : features.keypoints) spots.push_back({k.x, k.y, k.strength});
  const auto strengths = regional_strengths(spots, image.width, image.height, o.sift.max_features, o.sift.evenness);
  for (std::size_t i = 0; i < strengths.size(); ++i) features.keypoints[i].strength = strengths[i];
}

}  // namespace

Features detect_features(const GreyImage& image, const DetectOptions& o) {
  if (o.detector == Detector::kSift) return detect_sift(image, o.sift);
  if (std::min(image.width, image.height) < kLeastLevel_px || o.sift.max_features < 1) return {};
  Features found = corners(image, o);
  spread(found, image, o);
  return strongest_first(found);
}

std::size_t bytes_to_detect(int width, int height, const DetectOptions& o) {
  constexpr std::size_t kOfCorners = 13;  // a pixel
  if (o.detector == Detector::kSift) return bytes_to_detect_sift(width, height, o.sift);
  return kOfCorners * static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

}  // namespace collinea
