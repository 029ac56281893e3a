// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/control_prediction.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "collinea/adjust/outcome.h"
#include "collinea/base/parallel.h"
#include "collinea/quality/internal/point_cofactor.h"

namespace collinea::bundle {
namespace {

// The measurement in an image that takes part, or in one that is only oriented and counts as exact.
void add_measurement(const Block& block, const Problem& problem, const State& state,
                     const std::map<ImageId, int>& number, const ControlObservation& seen,
                     const Eigen::Vector3d& position, PointSystem& system) {
  const auto its = number.find(seen.image);
  const int image = its == number.end() ? -1 : its->second;
  const Rigid3& pose = pose_of(block, seen.image);
  const Eigen::Vector3d centre = centre_of(pose);
  const Frame frame = image >= 0 ? state.frames[image] : frame_of(pose.rotation.normalized(), centre.data());
  const Camera& camera = block.camera_of(seen.image);
  const Lens lens = image >= 0 ? state.lenses[problem.images[image].camera] : lens_of(camera, false);
  const Ray ray{{seen.pixel.x(), seen.pixel.y()}, 1 / seen.sigma_px, 0, 0, whitening_of(seen.shape)};
  LinearRay linear;
  linearise(ray, frame, lens, position.data(), Loss{}, &linear);
  system.add(linear, image, state);
}

}  // namespace

void predict_check_points(const Solved& solved, const TileCholesky& factor, const FreeNetwork& free_network,
                          const Run& run, Adjusted& adjusted) {
  const Block& block = solved.block();
  const Problem& problem = solved.problem();
  const State& state = solved.state();
  std::map<ImageId, int> number;
  for (std::size_t i = 0; i < problem.images.size(); ++i) number[problem.images[i].id] = static_cast<int>(i);
  std::map<ControlId, std::vector<const ControlObservation*>> measured;
  for (const ControlObservation& seen : block.control_observations)
    if (is_oriented(block, seen.image) && !is_left_out(adjusted, seen.image)) measured[seen.point].push_back(&seen);
  std::set<ControlId> took_part;
  for (std::size_t p = problem.first_control; p < problem.point_count(); ++p)
    if (problem.point(p).control >= 0) took_part.insert(ControlId{problem.point(p).id});
  parallel_for(run, adjusted.control.size(), [&](std::size_t i) {
    ControlDifference& check = adjusted.control[i];
    if (check.used || !check.position_in_world || took_part.contains(check.point)) return;
    PointSystem system(problem);
    const auto its_own = measured.find(check.point);
    if (its_own == measured.end()) return;
    std::vector<int> poses;
    for (const ControlObservation* seen : its_own->second) {
      add_measurement(block, problem, state, number, *seen, *check.position_in_world, system);
      const auto its = number.find(seen->image);
      poses.push_back(its == number.end() || its->second >= problem.poses ? -1 : its->second);
    }
    system.close(false, nullptr, nullptr);
    if (!system.determined()) return;
    check.covariance_m2 =
        free_network.of_check_point(system.covariance_by_solving(factor), system, *check.position_in_world, poses);
    const Eigen::Vector3d survey = block.control.at(check.point).sigma_m;
    for (int axis = 0; axis < 3; ++axis)
      if (std::isfinite(survey[axis]))
        check.difference_sigma_m[axis] =
            std::hypot(sigma_scale(adjusted) * std::sqrt((*check.covariance_m2)(axis, axis)), survey[axis]);
  });
}

void predict_control_points(const Solved& solved, TileCholesky& inverse, const FreeNetwork& free_network,
                            Adjusted& adjusted) {
  const Block& block = solved.block();
  const Problem& problem = solved.problem();
  const State& state = solved.state();
  for (std::size_t p = problem.first_control; p < problem.point_count(); ++p) {
    const ProblemPoint& point = problem.point(p);
    if (point.control < 0) continue;
    const auto its = std::find_if(adjusted.control.begin(), adjusted.control.end(),
                                  [&](const ControlDifference& c) { return c.point == ControlId{point.id}; });
    if (its == adjusted.control.end()) continue;
    if (point.is_fixed) {
      its->covariance_m2 = Eigen::Matrix3d::Zero();
      its->difference_sigma_m.setZero();
      continue;
    }
    const PointSystem system(problem, state, p);
    const Eigen::Matrix3d covariance = system.covariance(inverse);
    const Eigen::Matrix3d in_datum = its->covariance_m2.emplace(free_network.of_point(covariance, system, p));
    const ControlCoordinates& given = problem.control[point.control];
    const Eigen::Matrix3d survey = inverse_weight(given), by_survey = covariance * given.weight() * covariance;
    for (int axis = 0; axis < 3; ++axis) {
      if (!its->used)  // its coordinates did not take part
        its->difference_sigma_m[axis] = std::hypot(sigma_scale(adjusted) * std::sqrt(in_datum(axis, axis)),
                                                   block.control.at(its->point).sigma_m[axis]);
      if (!its->used && !std::isfinite(its->difference_sigma_m[axis]))
        its->difference_sigma_m[axis] = std::numeric_limits<double>::quiet_NaN();
      if (!(given.inverse_sigma[axis] > 0)) continue;
      // No motion of the datum moves a coordinate that is observed. The difference is (I - Q P) times that of the point
      // without its coordinates, whose variance is that of the block and that of the survey.
      const double of_survey = by_survey(axis, axis), whole = covariance(axis, axis);
      its->difference_sigma_m[axis] = std::sqrt(std::max(
          0.0, std::pow(sigma_scale(adjusted), 2) * (whole - of_survey) + survey(axis, axis) - 2 * whole + of_survey));
    }
  }
}

}  // namespace collinea::bundle
