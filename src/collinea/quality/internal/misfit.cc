// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/misfit.h"

#include <cmath>
#include <limits>
#include <set>

#include "collinea/adjust/outcome.h"

namespace collinea {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

class Comparison {
 public:
  Comparison(const Measurements& given, const Adjusted& adjusted) : given_(given), adjusted_(adjusted) {}

  std::vector<Misfit> misfits() {
    compare_tie_points();
    compare_control();
    compare_positions();
    for (const GeodeticDifference& one : adjusted_.geodetic) {
      const GeodeticObservation& measured = given_.block.geodetic[one.observation];
      if (measured.role == ControlRole::kControl)
        add({group_of(measured.kind), one.observation}, {-one.difference, 0, 0},
            Eigen::Vector3d::Constant(measured.sigma));
    }
    for (const AttitudeDifference& one : adjusted_.attitudes)
      if (const auto its = given_.scope.attitudes.find(one.image); its != given_.scope.attitudes.end())
        add_by_groups(ObservationSource::kAttitude, one.image.value, -one.difference_rad, its->second.sigma_rad);
    return std::move(found_);
  }

 private:
  // Not of axes that are not given.
  void add(MeasurementIndex index, const Eigen::Vector3d& off, const Eigen::Vector3d& sigma) {
    if (!axes_of(index.group, sigma).allFinite()) return;
    Misfit one{index, measurement_at(index, given_.block), off, kInfinity};
    if (const auto its = axes_of(index.group, off); its.allFinite())
      one.sigmas = its.cwiseQuotient(axes_of(index.group, sigma)).norm();
    else if (!is_image_point(index.group))
      return;
    found_.push_back(one);
  }

  void add_by_groups(ObservationSource source, std::uint32_t id, const Eigen::Vector3d& off,
                     const Eigen::Vector3d& sigma) {
    for (const ObservationGroup group : groups_of(source)) add({group, id}, off, sigma);
  }

  void add_ray(ObservationGroup group, std::size_t i, const Eigen::Vector2d& residual_px,
               const Eigen::Vector2d& sigmas_px) {
    add({group, static_cast<std::uint32_t>(i)}, {residual_px.x(), residual_px.y(), 0},
        {sigmas_px.x(), sigmas_px.y(), sigmas_px.x()});
  }

  void compare_tie_points() {
    for (std::size_t k = 0; k < adjusted_.observations.size(); ++k) {
      const std::size_t i = adjusted_.observations[k];
      add_ray(ObservationGroup::kTieImages, i, adjusted_.residuals_px[k], given_.block.observations[i].sigmas_px());
    }
  }

  void compare_control() {
    std::set<ControlId> used;
    for (const ControlDifference& one : adjusted_.control) {
      if (!one.used || !one.position_in_world) continue;
      used.insert(one.point);
      const ControlPoint& control = given_.block.control.at(one.point);
      add_by_groups(ObservationSource::kControlCoordinates, one.point.value,
                    control.position_in_world - *one.position_in_world, control.sigma_m);
    }
    for (std::size_t i = 0; i < given_.block.control_observations.size(); ++i) {
      const ControlObservation& seen = given_.block.control_observations[i];
      if (used.contains(seen.point) && is_oriented(given_.block, seen.image) &&
          !bundle::is_left_out(adjusted_, seen.image))
        add_ray(ObservationGroup::kControlImages, i, adjusted_.control_residuals_px[i], seen.sigmas_px());
    }
  }

  // Of antennas that are where the unknowns of images alone say.
  [[nodiscard]] bool positions_are_plain() const {
    return given_.scope.position_tracks.empty() && given_.scope.time_offset_sigma_s.empty() &&
           given_.scope.lever_arms.empty();
  }

  void compare_positions() {
    if (!given_.scope.use_positions) return;
    if (!positions_are_plain()) {
      for (const PositionDifference& one : adjusted_.positions)
        add_by_groups(ObservationSource::kPosition, one.image.value, -one.difference_m,
                      given_.block.images.at(one.image).position->sigma_m);
      return;
    }
    for (const auto& [id, pose] : adjusted_.cam_from_world)
      if (const auto& position = given_.block.images.at(id).position)
        add_by_groups(ObservationSource::kPosition, id.value, position->position_in_world - centre_of(pose),
                      position->sigma_m);
  }

  const Measurements& given_;
  const Adjusted& adjusted_;
  std::vector<Misfit> found_;
};

}  // namespace

std::vector<Misfit> misfits_of(const Measurements& given, const Adjusted& adjusted) {
  return Comparison(given, adjusted).misfits();
}

}  // namespace collinea
