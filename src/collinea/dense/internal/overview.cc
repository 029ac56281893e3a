// SPDX-License-Identifier: Apache-2.0
#include "collinea/dense/internal/overview.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "collinea/dense/internal/pinhole.h"
#include "collinea/dense/internal/window_variance.h"

namespace collinea::dense {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kConfirming = 3;
constexpr float kRoughReach = 3;       // of leaves and grass no two images show the same
constexpr float kStandsOut = 0.5f;     // of the inverse depth of what is around
constexpr float kRoughSigmaPx = 0.4f;  // of a pixel of the overview
constexpr float kRoughestPx = 2;
constexpr float kLeastTexture = 6;  // grey values, well above the noise of an image

// The surface of another image as seen from here: the nearest inverse depth that falls into each pixel.
FloatImage carried_over(const LocatedMap& other, const Camera& camera) {
  FloatImage result(camera.width_px, camera.height_px, 1, kNaN);
  const Pinhole from(other.map.camera), to(camera);
  const Eigen::Matrix3d rotation = other.reference_from_cam.rotation.toRotationMatrix();
  for (int y = 0; y < other.map.depth.height; ++y)
    for (int x = 0; x < other.map.depth.width; ++x) {
      const double z = double(other.map.depth.at(x, y));
      if (!(z > 0)) continue;
      const Eigen::Vector3d here = rotation * (from.ray(x + 0.5, y + 0.5) * z) + other.reference_from_cam.translation;
      if (!(here.z() > 0)) continue;
      const Eigen::Vector2d at = to.project(here);
      if (!(at.x() >= 0 && at.y() >= 0 && at.x() < camera.width_px && at.y() < camera.height_px)) continue;
      float& w = result.at(int(at.x()), int(at.y()));
      if (!(w >= float(1 / here.z()))) w = float(1 / here.z());
    }
  return result;
}

// Another image, asked whether it shows a point.
struct Onlooker {
  const Camera& camera;
  Pinhole pinhole;
  Eigen::Matrix3d rotation;  // other_from_reference
  Eigen::Vector3d translation;

  explicit Onlooker(const LocatedMap& other)
      : camera(other.map.camera),
        pinhole(camera),
        rotation(other.reference_from_cam.rotation.conjugate().toRotationMatrix()),
        translation(-(rotation * other.reference_from_cam.translation)) {}

  bool sees(const Eigen::Vector3d& point_in_reference_cam) const {
    const Eigen::Vector3d there = rotation * point_in_reference_cam + translation;
    return there.z() > 0 && inside(camera, pinhole.project(there));
  }
};

// The part of the surface that at least three images have on their images; NaN elsewhere.
FloatImage witnessed(const FloatImage& surface, const Camera& camera, const std::vector<LocatedMap>& others) {
  const std::vector<Onlooker> onlookers(others.begin(), others.end());
  const Pinhole here(camera);
  FloatImage result = surface;
  for (int y = 0; y < surface.height; ++y)
    for (int x = 0; x < surface.width; ++x) {
      if (std::isnan(surface.at(x, y))) continue;
      const Eigen::Vector3d point = here.ray(x + 0.5, y + 0.5) / double(surface.at(x, y));
      const auto looking = 1 + std::count_if(onlookers.begin(), onlookers.end(),
                                             [&](const Onlooker& other) { return other.sees(point); });
      if (looking < kConfirming) result.at(x, y) = kNaN;
    }
  return result;
}

// Two images are no witnesses of each other: their overviews come from the same pair of images. What only they have
// on their images goes where it stands out of what three see around it.
void empty_what_two_invent(const Camera& camera, const std::vector<LocatedMap>& others, FloatImage& surface) {
  const FloatImage by_three = witnessed(surface, camera, others);
  FloatImage around = by_three;
  fill_holes(around);
  for (std::size_t i = 0; i < surface.data.size(); ++i) {
    const bool by_two = std::isnan(by_three.data[i]), known = around.data[i] > 0;
    if (by_two && known && std::abs(surface.data[i] - around.data[i]) > kStandsOut * around.data[i])
      surface.data[i] = kNaN;
  }
}

// What one image says about a pixel: its inverse depths there and beside.
struct Opinion {
  std::array<float, 9> values;
  int count = 0;
  // The one nearest to w, NaN when none is within reach.
  float near(float w, float reach) const {
    float best = kNaN;
    for (int i = 0; i < count; ++i)
      if (const float off = std::abs(values[std::size_t(i)] - w); off <= reach && !(off >= std::abs(best - w)))
        best = values[std::size_t(i)];
    return best;
  }
};

Opinion opinion_at(const FloatImage& inverse_depth, int x, int y) {
  Opinion opinion;
  for (int j = std::max(y - 1, 0); j <= std::min(y + 1, inverse_depth.height - 1); ++j)
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, inverse_depth.width - 1); ++i)
      if (const float w = inverse_depth.at(i, j); w > 0) opinion.values[std::size_t(opinion.count++)] = w;
  return opinion;
}

// `candidates`: inverse depths at the pixel; `opinions`: that of the image itself first.
float agreed(const std::vector<float>& candidates, const std::vector<Opinion>& opinions, float reach) {
  float nearest = kNaN;
  for (const float candidate : candidates) {
    if (nearest >= candidate) continue;
    int agreeing = 0;
    float sum = 0;
    for (const Opinion& opinion : opinions)
      if (const float w = opinion.near(candidate, reach); !std::isnan(w)) ++agreeing, sum += w;
    const bool own_agrees = !std::isnan(opinions.front().near(candidate, reach));
    if (agreeing >= (own_agrees ? kConfirming - 1 : kConfirming)) nearest = sum / float(agreeing);
  }
  return nearest;
}

float grey_deviation(const GreyImage& image, int x, int y) {
  return std::sqrt(variance_around(x, y, kRadius, image.width, image.height,
                                   [&](int i, int j) { return float(image.at(i, j)) - 128; }));
}

float roughness(const FloatImage& surface, int x, int y) {
  const float middle = surface.at(x, y);
  return std::sqrt(variance_around(x, y, 1, surface.width, surface.height, [&](int i, int j) {
    const float value = surface.at(i, j);
    return std::isnan(value) ? 0 : value - middle;
  }));
}

}  // namespace

FloatImage agreed_surface(const DepthMap& own, const std::vector<LocatedMap>& others, float reach) {
  std::vector<FloatImage> maps(1, own.depth);
  for (float& value : maps.front().data) value = 1 / value;
  for (const LocatedMap& other : others) maps.push_back(carried_over(other, own.camera));
  FloatImage result(own.depth.width, own.depth.height, 1, kNaN);
  std::vector<float> candidates;
  std::vector<Opinion> opinions;
  for (int y = 0; y < result.height; ++y)
    for (int x = 0; x < result.width; ++x) {
      candidates.clear();
      opinions.clear();
      for (const FloatImage& map : maps) {
        if (const float w = map.at(x, y); w > 0) candidates.push_back(w);
        opinions.push_back(opinion_at(map, x, y));
      }
      result.at(x, y) = agreed(candidates, opinions, reach);
      if (std::isnan(result.at(x, y))) result.at(x, y) = agreed(candidates, opinions, kRoughReach * reach);
    }
  empty_what_two_invent(own.camera, others, result);
  return result;
}

void fill_rough(const Level& finest, const TextureCentroid& centroid, const FloatImage& agreed, Refined& result) {
  const FloatImage surface = median3(agreed);
  const int factor = int(std::lround(double(finest.image->width) / agreed.width));
  const float px = float(factor) * finest.step / finest.parallax_px;
  for (int y = 0; y < result.inverse_depth.height; ++y)
    for (int x = 0; x < result.inverse_depth.width; ++x) {
      float& w = result.inverse_depth.at(x, y);
      if (!std::isnan(w) || centroid.is_aside(x, y) || grey_deviation(*finest.image, x, y) < kLeastTexture) continue;
      const int i = x / factor, j = y / factor;
      if (i >= agreed.width || j >= agreed.height || std::isnan(agreed.at(i, j))) continue;
      const float rough = roughness(surface, i, j);
      if (!(rough <= kRoughestPx * px)) continue;
      const float smooth = bilinear(surface, (x + 0.5) / factor, (y + 0.5) / factor);
      w = std::isnan(smooth) ? surface.at(i, j) : smooth;
      result.sigma.at(x, y) = std::hypot(kRoughSigmaPx * px, rough);
    }
}

}  // namespace collinea::dense
