// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/bundle_of_models.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "collinea/orient/approximate.h"
#include "collinea/quality/examine.h"

namespace collinea {
namespace {

using Eigen::Vector3d;

// Which point of which image a model keeps.
std::set<std::pair<ImageId, std::string>> measured_in(const ModelsOfBlock& formed, const JoinedBlock& joined) {
  std::set<std::pair<ImageId, std::string>> measured;
  std::size_t m = 0;
  for (const FormedModel& pair : formed.pairs) {
    if (!pair.failure.empty()) continue;
    if (joined.models[m])
      for (const NamedPoint& point : formed.models[m].points)
        for (const ImageId image : {pair.left, pair.right}) measured.emplace(image, point.name);
    ++m;
  }
  return measured;
}

// The block anew: surveyed points are its control, all others its tie points, and all of them have the positions of the
// joined models.
class Rebuilt {
 public:
  Rebuilt(const Block& from, const std::vector<SurveyedPoint>& control, const JoinedBlock& joined) {
    block.georeference = from.georeference;
    block.cameras = from.cameras;
    for (const JoinedPoint& point : joined.points) positions_[point.name] = point.position;
    for (const SurveyedPoint& given : control) {
      const ControlId id{static_cast<std::uint32_t>(controls_.size())};
      ControlPoint point;
      point.name = given.name;
      point.role = given.is_check ? ControlRole::kCheck : ControlRole::kControl;
      point.sigma_m = given.sigma;
      point.position_in_world = point.position_in_map = given.position;
      if (const auto at = positions_.find(given.name); at != positions_.end())
        for (int axis = 0; axis < 3; ++axis)
          if (!given.has(axis)) point.position_in_world[axis] = at->second[axis];
      controls_[given.name] = id;
      block.control[id] = point;
    }
  }

  void add(const Block& from, ImageId image, const std::string& name, const auto& one) {
    if (block.images.try_emplace(image, from.images.at(image)).second) {
      block.images.at(image).position.reset();
      if (const auto pose = find_pose(from, image)) set_pose(block, image, *pose);
    }
    if (const auto control = controls_.find(name); control != controls_.end()) {
      block.control_observations.push_back({control->second, image, one.pixel, one.sigma_px, one.shape});
      return;
    }
    const auto [tie, is_new] = ties.try_emplace(name, PointId{static_cast<std::uint32_t>(ties.size())});
    if (is_new) block.points[tie->second] = TiePoint{positions_.at(name), {}};
    block.observations.push_back({image, tie->second, 0, one.pixel, one.sigma_px, one.shape});
  }

  Block block;
  std::map<std::string, PointId> ties;

 private:
  std::map<std::string, ControlId> controls_;
  std::map<std::string, Vector3d> positions_;
};

Rebuilt rebuilt(const Block& from, const ModelsOfBlock& formed, const std::vector<SurveyedPoint>& control,
                const JoinedBlock& joined) {
  Rebuilt made(from, control, joined);
  auto measured = measured_in(formed, joined);
  for (const Observation& one : from.observations) {
    const std::string name = std::to_string(one.point.value);
    if (measured.erase({one.image, name}) > 0) made.add(from, one.image, name, one);
  }
  for (const ControlObservation& one : from.control_observations)
    if (const auto point = from.control.find(one.point); point != from.control.end())
      if (measured.erase({one.image, point->second.name}) > 0) made.add(from, one.image, point->second.name, one);
  std::sort(made.block.observations.begin(), made.block.observations.end(),
            [](const Observation& a, const Observation& b) {
              return std::pair(a.point, a.image) < std::pair(b.point, b.image);
            });
  return made;
}

// Least squares to the last step, of all that moves but the cameras.
Result<Examined> adjusted(const Block& block, const Run& run) {
  AdjustScope scope;
  for (const auto& [id, camera] : block.cameras) scope.fixed_cameras.insert(id);
  scope.use_positions = scope.use_geodetic = false;
  scope.use_check_rays = true;
  ExamineOptions options;
  options.adjust.calibration = Calibration::kNone;
  options.adjust.loss = options.adjust.position_loss = Loss::kNone;
  options.adjust.step_sigmas = 1e-4;
  options.adjust.relative_cost_change = 1e-12;
  options.adjust.settle_points = true;
  options.point_covariances = true;
  COLLINEA_TRY(Examined found, examine(block, scope, options, run));
  if (found.undetermined || found.point_covariance.size() != found.points.size())
    return fail(Errc::kIllPosed, "the bundle of these measurements is not determined");
  if (!found.converged) return fail(Errc::kNotConverged, "the bundle of these measurements has not converged");
  return found;
}

void add_points(const Rebuilt& made, const Examined& found, double factor, BundleOfModels& bundle) {
  std::map<PointId, std::size_t> index;
  for (std::size_t i = 0; i < found.points.size(); ++i) index[found.points[i].first] = i;
  for (const auto& [name, id] : made.ties)
    if (const auto at = index.find(id); at != index.end())
      bundle.points[name] = {found.points[at->second].second, factor * found.point_covariance[at->second]};
  for (const ControlDifference& one : found.control)
    if (one.position_in_world && one.covariance_m2)
      bundle.points[made.block.control.at(one.point).name] = {*one.position_in_world, factor * *one.covariance_m2};
  for (const auto& [image, pose] : found.cam_from_world)
    if (const auto known = found.pose_covariance.find(image); known != found.pose_covariance.end())
      bundle.points[made.block.images.at(image).file] = {centre_of(pose),
                                                         factor * known->second.bottomRightCorner<3, 3>()};
}

}  // namespace

Result<BundleOfModels> bundle_of_models(const Block& block, const ModelsOfBlock& formed,
                                        const std::vector<SurveyedPoint>& control, const JoinedBlock& joined,
                                        bool sigmas_known, const Run& run) {
  if (!joined.chain.on_ground)
    return fail(Errc::kBadInput, "without control models and bundle have no frame in common: nothing to compare");
  Rebuilt made = rebuilt(block, formed, control, joined);
  COLLINEA_TRY(const Approximation start, approximate(made.block, run.seed));
  if (!start.without_pose.empty())
    return fail(Errc::kIllPosed, fmt::format("the joined models do not orient image {} for the bundle",
                                             made.block.images.at(start.without_pose.front()).file));
  COLLINEA_TRY(const Examined found, adjusted(made.block, run));
  BundleOfModels bundle;
  bundle.sigma0 = found.redundancy > 0 ? found.sigma0 : std::numeric_limits<double>::quiet_NaN();
  bundle.observations = found.observation_count;
  bundle.unknowns = found.unknown_count;
  bundle.redundancy = found.redundancy;
  const double scale = sigmas_known ? 1 : sigma_scale(found);
  add_points(made, found, scale * scale, bundle);
  return bundle;
}

BundleComparison compare(const JoinedBlock& joined, const BundleOfModels& bundle) {
  BundleComparison sums;
  Eigen::Array3d with_sigma = Eigen::Array3d::Zero();
  for (const JoinedPoint& point : joined.points) {
    const auto other = bundle.points.find(point.name);
    if (other == bundle.points.end()) continue;
    ++sums.points;
    const Vector3d difference = point.position - other->second.position;
    sums.apart += difference.cwiseAbs2();
    for (int axis = 0; axis < 3; ++axis) {
      const double variance = other->second.covariance(axis, axis);
      if (!(variance > 0)) continue;
      ++with_sigma[axis];
      sums.apart_in_sigmas[axis] += difference[axis] * difference[axis] / variance;
      sums.ratio[axis] += std::sqrt(std::max(0.0, point.covariance(axis, axis)) / variance);
    }
  }
  const Eigen::Array3d n = with_sigma.max(1);
  sums.apart = (sums.apart / std::max(sums.points, 1)).cwiseSqrt();
  sums.apart_in_sigmas = (sums.apart_in_sigmas.array() / n).sqrt().matrix();
  sums.ratio = (sums.ratio.array() / n).matrix();
  return sums;
}

}  // namespace collinea
