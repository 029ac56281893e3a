// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/mark_factor.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace collinea {
namespace {

constexpr double kSmallest = 0.02, kLargest = 5000;  // factors; millimetres on pixels of 2 um have 500
constexpr double kBin = 0.004;                       // of the logarithm
constexpr std::size_t kModes = 4;
constexpr std::size_t kMostRays = 12;  // of a point

// The ray of a mark in the world is s * by_factor + fixed.
struct RayAlongFactor {
  Eigen::Vector3d by_factor, fixed, centre;
  double focal_px;
};

RayAlongFactor along_factor(const MarkedRay& ray, MarkSystem system) {
  const Camera& camera = *ray.camera;
  const MarkMap map = map_of({system, 1}, camera.width_px, camera.height_px);
  const Eigen::Vector2d middle(camera.params[Camera::kCx], camera.params[Camera::kCy]);
  const Eigen::Vector2d moving = map.linear * ray.given / camera.focal_px(),
                        fixed = (map.origin - middle) / camera.focal_px();
  const Eigen::Quaterniond world_from_cam = ray.cam_from_world.rotation.conjugate();
  return {world_from_cam * Eigen::Vector3d(moving.x(), moving.y(), 0),
          world_from_cam * Eigen::Vector3d(fixed.x(), fixed.y(), 1), centre_of(ray.cam_from_world), camera.focal_px()};
}

// Positive roots of a s^2 + b s + c.
std::vector<double> positive_roots(double a, double b, double c) {
  const double under = b * b - 4 * a * c;
  if (!(under >= 0)) return {};
  const double q = -(b + std::copysign(std::sqrt(under), b)) / 2;
  std::vector<double> roots;
  for (const double root : std::array{a != 0 ? q / a : -1, q != 0 ? c / q : -1})
    if (root > kSmallest && root < kLargest) roots.push_back(root);
  return roots;
}

class Histogram {
 public:
  Histogram() : weights_(std::size_t(std::log(kLargest / kSmallest) / kBin) + 2) {}

  void add(double factor, double weight) { weights_[std::size_t(std::log(factor / kSmallest) / kBin)] += weight; }

  // Middles of the heaviest triples of bins that do not overlap.
  [[nodiscard]] std::vector<double> modes() {
    std::vector<double> found;
    while (found.size() < kModes) {
      std::size_t best = 0;
      for (std::size_t i = 1; i + 1 < weights_.size(); ++i)
        if (triple(i) > (best ? triple(best) : 0)) best = i;
      if (best == 0) break;
      found.push_back(kSmallest * std::exp((double(best) + 0.5) * kBin));
      for (std::size_t i = best - std::min<std::size_t>(best, 2); i < std::min(best + 3, weights_.size()); ++i)
        weights_[i] = 0;
    }
    return found;
  }

 private:
  [[nodiscard]] double triple(std::size_t i) const { return weights_[i - 1] + weights_[i] + weights_[i + 1]; }

  std::vector<double> weights_;
};

void add_pair(const RayAlongFactor& one, const RayAlongFactor& other, Histogram& histogram) {
  const Eigen::Vector3d base = other.centre - one.centre;
  const double a = base.dot(one.by_factor.cross(other.by_factor)),
               b = base.dot(one.by_factor.cross(other.fixed) + one.fixed.cross(other.by_factor)),
               c = base.dot(one.fixed.cross(other.fixed));
  for (const double root : positive_roots(a, b, c)) {
    const double length =
        std::max((root * one.by_factor + one.fixed).norm(), (root * other.by_factor + other.fixed).norm());
    const double of_a_pixel = base.norm() * length / std::min(one.focal_px, other.focal_px);
    const double relative_sigma = of_a_pixel / (std::abs(2 * a * root + b) * root);
    histogram.add(root, 1 / (1 + std::pow(relative_sigma / kBin, 2)));
  }
}

}  // namespace

std::vector<double> likely_factors(const std::vector<std::vector<MarkedRay>>& points, MarkSystem system) {
  Histogram histogram;
  for (const std::vector<MarkedRay>& point : points) {
    std::vector<RayAlongFactor> rays;
    for (std::size_t i = 0; i < std::min(point.size(), kMostRays); ++i) {
      if (is_fisheye(point[i].camera->model)) continue;
      rays.push_back(along_factor(point[i], system));
    }
    for (std::size_t i = 0; i < rays.size(); ++i)
      for (std::size_t j = i + 1; j < rays.size(); ++j) add_pair(rays[i], rays[j], histogram);
  }
  return histogram.modes();
}

}  // namespace collinea
