// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/approximate.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "collinea/epipolar/intersect.h"
#include "collinea/orient/internal/resection.h"

namespace collinea {
namespace {

// A lens may be known badly beforehand (a camera that is to be calibrated): then even good measurements lie this part
// of the image's width off, and that is what a pose may miss them by.
constexpr double kLoosePart = 0.1;
constexpr int kLeastPoints = 4;  // three have up to four solutions

struct Known {
  std::vector<Eigen::Vector2d> pixels;
  std::vector<Eigen::Vector3d> positions;
};

class Approximator {
 public:
  Approximator(Block& block, std::uint64_t seed, RobustStart start) : block_(block), seed_(seed), start_(start) {
    for (std::size_t i = 0; i < block.observations.size(); ++i) {
      of_image_[block.observations[i].image].push_back(i);
      of_point_[block.observations[i].point].push_back(i);
    }
  }

  Result<Approximation> approximate() {
    std::set<PointId> missing;
    for (const auto& [point, positions] : of_point_)
      if (!block_.points.contains(point)) missing.insert(point);
    intersect_all(missing);
    while (resect_best()) intersect_all(missing);
    if (oriented_images(block_).empty())
      return fail(
          Errc::kIllPosed,
          "no image has an approximate pose, and none can be resected, which takes four measured control points "
          "that do not lie on a line: give the poses of two images at least, or measure more control");
    for (const auto& [id, image] : block_.images)
      if (!is_oriented(block_, id)) found_.without_pose.push_back(id);
    found_.without_position.assign(missing.begin(), missing.end());
    return std::move(found_);
  }

 private:
  [[nodiscard]] Known known_in(ImageId image) const {
    Known known;
    for (const ControlObservation& seen : block_.control_observations) {
      const ControlPoint& control = block_.control.at(seen.point);
      if (seen.image != image || control.role != ControlRole::kControl || !control.sigma_m.allFinite()) continue;
      known.pixels.push_back(seen.pixel);
      known.positions.push_back(control.position_in_world);
    }
    if (const auto its = of_image_.find(image); its != of_image_.end())
      for (const std::size_t i : its->second)
        if (const auto point = block_.points.find(block_.observations[i].point); point != block_.points.end()) {
          known.pixels.push_back(block_.observations[i].pixel);
          known.positions.push_back(point->second.position_in_world);
        }
    return known;
  }

  // The image that sees most known points, or the next that can be resected; false when there is none.
  bool resect_best() {
    std::vector<std::pair<std::size_t, ImageId>> order;
    std::map<ImageId, Known> known;
    for (const auto& [id, image] : block_.images) {
      if (is_oriented(block_, id)) continue;
      Known its = known_in(id);
      if (its.pixels.size() < kLeastPoints) continue;
      order.emplace_back(its.pixels.size(), id);
      known[id] = std::move(its);
    }
    std::stable_sort(order.begin(), order.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
    for (const auto& [count, id] : order) {
      const Camera& camera = block_.camera_of(id);
      const ResectOptions options{.max_error_px = kLoosePart * std::max(camera.width_px, camera.height_px),
                                  .min_inliers = kLeastPoints,
                                  .min_inlier_ratio = 0.5,
                                  .start = start_};
      const auto pose = resect(camera, known[id].pixels, known[id].positions, options, seed_);
      if (!pose) continue;
      set_pose(block_, id, pose->cam_from_world);
      found_.resected.push_back(id);
      return true;
    }
    return false;
  }

  void intersect_all(std::set<PointId>& missing) {
    for (auto point = missing.begin(); point != missing.end();) {
      std::vector<SightLine> lines;
      for (const std::size_t i : of_point_.at(*point)) {
        const Observation& seen = block_.observations[i];
        if (const std::optional<Rigid3> pose = find_pose(block_, seen.image))
          lines.push_back({&block_.camera_of(seen.image), *pose, seen.pixel, seen.sigma_px});
      }
      const auto met = intersect(lines);
      if (!met) {
        ++point;
        continue;
      }
      block_.points[*point] = {met->point_in_world, {}};
      ++found_.intersected;
      point = missing.erase(point);
    }
  }

  Block& block_;
  std::uint64_t seed_;
  RobustStart start_;
  std::map<ImageId, std::vector<std::size_t>> of_image_;
  std::map<PointId, std::vector<std::size_t>> of_point_;
  Approximation found_;
};

}  // namespace

Result<Approximation> approximate(Block& block, std::uint64_t seed, RobustStart start) {
  return Approximator(block, seed, start).approximate();
}

}  // namespace collinea
