// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/mark_network.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "collinea/epipolar/intersect.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

constexpr double kAgree = 10;          // sigmas: rays that meet like that are not looked at one by one
constexpr std::size_t kMostLines = 8;  // of which all pairs are tried

// Where the pair of lines meets that the others agree with best: the sum of the roots of their misses is least, which
// no single miss decides.
std::optional<Eigen::Vector3d> meet_robustly(const std::vector<SightLine>& lines) {
  const auto all = intersect(lines);
  if (all && (lines.size() < 3 || all->sigma0 < kAgree)) return all->point_in_world;
  std::optional<Eigen::Vector3d> best;
  double least = std::numeric_limits<double>::infinity();
  const std::size_t step = (lines.size() + kMostLines - 1) / kMostLines;
  for (std::size_t i = 0; i < lines.size(); i += step)
    for (std::size_t k = i + step; k < lines.size(); k += step) {
      const auto met = intersect(std::vector<SightLine>{lines[i], lines[k]});
      if (!met) continue;
      double misses = 0;
      for (const SightLine& line : lines) misses += std::sqrt(miss_px(line, met->point_in_world));
      if (misses >= least) continue;
      least = misses;
      best = met->point_in_world;
    }
  return best;
}

class Network {
 public:
  Network(const Measurements& given, const Run& run) : run_(run), block_(given.block) {
    scope_.first_cameras = given.scope.first_cameras;
    scope_.fixed_images = given.scope.fixed_images;
    scope_.corrected_cameras = given.scope.corrected_cameras;
    scope_.use_positions = scope_.use_control = scope_.use_geodetic = false;
    std::uint32_t next = block_.points.empty() ? 1 : block_.points.rbegin()->first.value + 1;
    if (!block_.observations.empty()) next = std::max(next, block_.observations.back().point.value + 1);
    first_mark_ = PointId{next};
    std::map<ControlId, std::map<ImageId, const ControlObservation*>> marks;
    for (const ControlObservation& seen : block_.control_observations)
      if (is_oriented(block_, seen.image)) marks[seen.point].emplace(seen.image, &seen);
    for (const auto& [id, its] : marks) {
      const PointId as_tie = mark_of_[id] = PointId{next++};
      for (const auto& [image, seen] : its)
        block_.observations.push_back({image, as_tie, 0, seen->pixel, seen->sigma_px, seen->shape});
    }
    block_.control.clear();
    block_.control_observations.clear();
    block_.geodetic.clear();
  }

  Result<MarkNetwork> adjust() {
    AdjustOptions options{.calibration = Calibration::kNone, .loss = Loss::kHuber, .relative_cost_change = 1e-5};
    for (const Loss::Kind loss : {Loss::kHuber, Loss::kCauchy, Loss::kCauchy}) {
      intersect_all();
      options.loss = loss;
      COLLINEA_TRY(const Adjusted adjusted, collinea::adjust(block_, scope_, options, run_));
      apply(adjusted, block_);
      // Twice what most residuals are: a lens that is not known yet leaves systematic ones.
      typical_sigmas_ = typical_sigmas(adjusted);
      options.loss_scale_sigmas = std::clamp(2 * typical_sigmas_, 2.0, 1e6);
    }
    intersect_all();
    return result();
  }

 private:
  void intersect_all() {
    const auto& seen = block_.observations;
    for (std::size_t i = 0, end = 0; i < seen.size(); i = end) {
      std::vector<SightLine> lines;
      for (end = i; end < seen.size() && seen[end].point == seen[i].point; ++end)
        if (const auto pose = find_pose(block_, seen[end].image))
          lines.push_back(
              {&block_.camera_of(seen[end].image), *pose, seen[end].pixel, seen[end].sigma_px, seen[end].shape});
      const PointId point = seen[i].point;
      if (lines.size() < 2 || (point < first_mark_ && !block_.points.contains(point))) continue;
      if (const auto met = meet_robustly(lines)) {
        block_.points[point].position_in_world = *met;
        located_.insert(point);
      } else {
        located_.erase(point);
      }
    }
  }

  [[nodiscard]] double typical_sigmas(const Adjusted& adjusted) const {
    std::vector<double> sigmas;
    for (std::size_t k = 0; k < adjusted.observations.size(); ++k)
      if (const Eigen::Vector2d& px = adjusted.residuals_px[k]; px.allFinite())
        sigmas.push_back(px.norm() / block_.observations[adjusted.observations[k]].sigma_px);
    return sigmas.empty() ? 1 : median(std::move(sigmas)) / 1.18;
  }

  MarkNetwork result() {
    MarkNetwork network{.typical_sigmas = typical_sigmas_};
    for (const auto& [id, point] : block_.points)
      if (located_.contains(id)) network.points[id] = point.position_in_world;
    for (const auto& [id, as_tie] : mark_of_)
      if (located_.contains(as_tie)) {
        network.marked[id] = network.points.at(as_tie);
        network.points.erase(as_tie);
      }
    network.block = std::move(block_);
    return network;
  }

  const Run& run_;
  Block block_;
  AdjustScope scope_;
  PointId first_mark_;  // from here on points are marks of control
  std::map<ControlId, PointId> mark_of_;
  std::set<PointId> located_;
  double typical_sigmas_ = 1;
};

}  // namespace

double miss_px(const SightLine& line, const Eigen::Vector3d& position) {
  constexpr double kLost_px = 1e4;
  const auto pixel = project(*line.camera, line.cam_from_world * position);
  return pixel ? std::min(kLost_px, (*pixel - line.pixel).norm()) : kLost_px;
}

Result<MarkNetwork> mark_network_of(const Measurements& given, const Run& run) { return Network(given, run).adjust(); }

}  // namespace collinea
