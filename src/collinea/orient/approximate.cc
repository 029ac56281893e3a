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

// Marked, and not surveyed on all axes: its position is to be found.
bool is_only_marked(const ControlPoint& control) {
  return control.role == ControlRole::kControl && !control.sigma_m.allFinite();
}

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
    for (std::size_t i = 0; i < block.control_observations.size(); ++i)
      if (const ControlId point = block.control_observations[i].point; is_only_marked(block.control.at(point)))
        of_mark_[point].push_back(i);
  }

  Result<Approximation> approximate() {
    std::set<PointId> missing;
    for (const auto& [point, positions] : of_point_)
      if (!block_.points.contains(point)) missing.insert(point);
    do {
      intersect_all(missing);
      intersect_marks();
    } while (resect_best());
    if (oriented_images(block_).empty())
      return fail(
          Errc::kIllPosed,
          "no image has an approximate pose, and none can be resected, which takes four measured control points "
          "that do not lie on a line: give the poses of two images at least, or measure more control");
    for (const auto& [id, image] : block_.images)
      if (!is_oriented(block_, id)) found_.without_pose.push_back(id);
    found_.without_position.assign(missing.begin(), missing.end());
    for (const auto& [point, rows] : of_mark_)
      if (!marks_.contains(point)) found_.marked_without_position.push_back(point);
    return std::move(found_);
  }

 private:
  [[nodiscard]] Known known_in(ImageId image) const {
    Known known;
    for (const ControlObservation& seen : block_.control_observations) {
      const ControlPoint& control = block_.control.at(seen.point);
      const auto mark = marks_.find(seen.point);
      const bool is_given = control.role == ControlRole::kControl && control.sigma_m.allFinite();
      if (seen.image != image || (!is_given && mark == marks_.end())) continue;
      known.pixels.push_back(seen.pixel);
      known.positions.push_back(is_given ? control.position_in_world : mark->second);
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

  [[nodiscard]] std::optional<Intersection> met_by(const auto& observations, const std::vector<std::size_t>& rows) {
    std::vector<SightLine> lines;
    for (const std::size_t i : rows)
      if (const std::optional<Rigid3> pose = find_pose(block_, observations[i].image))
        lines.push_back({&block_.camera_of(observations[i].image), *pose, observations[i].pixel,
                         observations[i].sigma_px, observations[i].shape});
    return intersect(lines);
  }

  void intersect_marks() {
    for (const auto& [point, rows] : of_mark_) {
      if (marks_.contains(point)) continue;
      const auto met = met_by(block_.control_observations, rows);
      if (!met) continue;
      marks_[point] = met->point_in_world;
      ++found_.intersected;
    }
  }

  void intersect_all(std::set<PointId>& missing) {
    for (auto point = missing.begin(); point != missing.end();) {
      const auto met = met_by(block_.observations, of_point_.at(*point));
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
  std::map<ControlId, std::vector<std::size_t>> of_mark_;  // of those that have no coordinates
  std::map<ControlId, Eigen::Vector3d> marks_;             // where these were found
  Approximation found_;
};

}  // namespace

Result<Approximation> approximate(Block& block, std::uint64_t seed, RobustStart start) {
  return Approximator(block, seed, start).approximate();
}

}  // namespace collinea
