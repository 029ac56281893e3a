// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/taming.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "collinea/quality/internal/robust_fit.h"

namespace collinea {
namespace {

constexpr double kCertain = 4, kLeastSigmas = 30;  // minimal detectable biases, sigmas: what is left of a misfit
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ObservationSource source_of(const Misfit& one) { return traits_of(one.index.group).source; }

// The given sigma on the axes of the group.
Eigen::Vector3d sigma_of(MeasurementIndex index, const Measurements& given) {
  const Block& block = given.block;
  switch (traits_of(index.group).source) {
    case ObservationSource::kTieImagePoint:
      return Eigen::Vector3d::Constant(block.observations[index.source].sigma_px);
    case ObservationSource::kControlImagePoint:
      return Eigen::Vector3d::Constant(block.control_observations[index.source].sigma_px);
    case ObservationSource::kControlCoordinates:
      return block.control.at(ControlId{index.source}).sigma_m;
    case ObservationSource::kPosition:
      return block.images.at(ImageId{index.source}).position->sigma_m;
    case ObservationSource::kGeodetic:
      return Eigen::Vector3d::Constant(block.geodetic[index.source].sigma);
    case ObservationSource::kAttitude:
      return given.scope.attitudes.at(ImageId{index.source}).sigma_rad;
  }
  bug("a measurement without a source");
}

bool is_fixed(const Misfit& one, const Measurements& given) {
  return source_of(one) == ObservationSource::kControlCoordinates &&
         (axes_of(one.index.group, sigma_of(one.index, given)).array() == 0).all();
}

// Takes that part of its misfit off the value of a measurement.
void reduce(const Misfit& one, double part, Block& block) {
  const Eigen::Vector3d by = part * one.off;
  switch (source_of(one)) {
    case ObservationSource::kTieImagePoint:
      block.observations[one.index.source].pixel -= by.head<2>();
      return;
    case ObservationSource::kControlImagePoint:
      block.control_observations[one.index.source].pixel -= by.head<2>();
      return;
    case ObservationSource::kControlCoordinates:
      axes_of(one.index.group, block.control.at(ControlId{one.index.source}).position_in_world) -=
          axes_of(one.index.group, by);
      return;
    case ObservationSource::kPosition:
      axes_of(one.index.group, block.images.at(ImageId{one.index.source}).position->position_in_world) -=
          axes_of(one.index.group, by);
      return;
    case ObservationSource::kGeodetic:
      block.geodetic[one.index.source].value -= by.x();
      return;
    case ObservationSource::kAttitude:
      return;
  }
}

// How many sigmas an error of each measurement must have to be found for certain, by an adjustment without any. Of tie
// points the redundancy of single rays would be needed; thirty sigmas are enough but where next to nothing checks them.
std::map<Measurement, double> certain_sigmas(const Measurements& healed, const ExamineOptions& options,
                                             const Run& run) {
  std::map<Measurement, double> certain;
  const Result<Examined> adjusted = examine(healed.block, healed.scope, options, run);
  if (!adjusted || !adjusted->reliability) return certain;
  for (const TestedObservation& one : adjusted->reliability->others)
    if (const double bias = one.minimal_detectable_bias; std::isfinite(bias)) {
      double& sigmas = certain[measurement_at({one.group, one.source}, healed.block)];
      sigmas = std::max(sigmas, kCertain * bias / one.sigma);
    }
  return certain;
}

}  // namespace

Rejection gross_rejection(const Misfit& misfit, const Measurements& given) {
  Rejection rejection{.given = given_at(misfit.index, given)};
  Rejected& rejected = rejection.rejected;
  static_cast<Measurement&>(rejected) = misfit.measurement;
  const ObservationGroupTraits& traits = traits_of(misfit.index.group);
  rejected.axis = traits.first_axis;
  for (int axis = traits.first_axis; axis < traits.first_axis + traits.axes; ++axis) {
    rejected.gross_error[axis] = misfit.off[axis];
    if (std::abs(misfit.off[axis]) > std::abs(misfit.off[rejected.axis])) rejected.axis = axis;
  }
  rejection.sigma = rejected.sigma = sigma_of(misfit.index, given)[rejected.axis];
  rejected.w = misfit.sigmas;
  rejected.redundancy = rejected.influence = kNaN;
  return rejection;
}

std::optional<Tamed> tame(const Measurements& given, const ExamineOptions& options, const Run& run) {
  Result<RobustFit> fit = robust_fit(given, options.adjust, run);
  if (!fit) return std::nullopt;
  Tamed out;
  std::vector<MeasurementIndex> untestable;
  for (const Misfit& one : gross_misfits(*fit)) {
    if (source_of(one) == ObservationSource::kAttitude) continue;
    if (std::isfinite(one.sigmas) && !is_fixed(one, given)) {
      out.tamed.push_back({one});
      continue;
    }
    out.remaining.rejections.push_back(gross_rejection(one, given));
    untestable.push_back(one.index);
  }
  if (out.tamed.empty() && untestable.empty()) return std::nullopt;
  Measurements all = given;
  all.block.poses = fit->measurements.block.poses;
  all.block.points = fit->measurements.block.points;
  all.block.cameras = fit->measurements.block.cameras;
  Measurements healed = all;
  for (const TamedMisfit& one : out.tamed) reduce(one, 1, healed.block);
  const std::map<Measurement, double> certain = certain_sigmas(without(std::move(healed), untestable), options, run);
  for (TamedMisfit& one : out.tamed) {
    const auto its = certain.find(one.measurement);
    one.left = std::min(1.0, std::max(kLeastSigmas, its == certain.end() ? 0 : its->second) / one.sigmas);
    reduce(one, 1 - one.left, all.block);
  }
  out.remaining.measurements = without(std::move(all), untestable);
  return out;
}

namespace {

// Gives a tamed measurement that is no image point its value again.
void restore_value(const Misfit& one, const Block& given, Block& block) {
  const std::uint32_t source = one.index.source;
  switch (source_of(one)) {
    case ObservationSource::kControlCoordinates:
      block.control.at(ControlId{source}).position_in_world = given.control.at(ControlId{source}).position_in_world;
      return;
    case ObservationSource::kPosition:
      block.images.at(ImageId{source}).position->position_in_world =
          given.images.at(ImageId{source}).position->position_in_world;
      return;
    case ObservationSource::kGeodetic:
      block.geodetic[source].value = given.geodetic[source].value;
      return;
    default:
      return;
  }
}

}  // namespace

Remaining as_given(Remaining remaining, const std::vector<TamedMisfit>& tamed, const Measurements& given) {
  Block& block = remaining.measurements.block;
  std::map<Measurement, const TamedMisfit*> known;
  for (const TamedMisfit& one : tamed) {
    known[one.measurement] = &one;
    restore_value(one, given.block, block);
  }
  const auto restore_pixel = [&](const Measurement& name, auto& seen) {
    if (const auto its = known.find(name); its != known.end())
      seen = std::get<std::remove_reference_t<decltype(seen)>>(given_at(its->second->index, given));
  };
  for (Observation& seen : block.observations)
    restore_pixel({.group = ObservationGroup::kTieImages, .image = seen.image, .point = seen.point}, seen);
  for (ControlObservation& seen : block.control_observations)
    restore_pixel({.group = ObservationGroup::kControlImages, .image = seen.image, .control = seen.point}, seen);
  for (Rejection& rejection : remaining.rejections) {
    const auto its = known.find(rejection.rejected);
    if (its == known.end()) continue;
    if (is_image_point(rejection.rejected.group)) rejection.given = given_at(its->second->index, given);
    rejection.rejected.w /= its->second->left;
    rejection.rejected.influence /= its->second->left;
  }
  return remaining;
}

}  // namespace collinea
