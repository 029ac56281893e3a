// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/gross_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "collinea/quality/internal/rivals.h"
#include "collinea/quality/internal/robust_fit.h"

namespace collinea {
namespace {

constexpr double kSame = 0.99;             // correlation of the tests of two observations
constexpr double kFitsAsWell = 50;         // squared sigmas by which the sum of squares may be larger
constexpr std::size_t kMostOnGround = 20;  // decided one by one
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

ObservationSource source_of(const Misfit& one) { return traits_of(one.index.group).source; }

Eigen::Vector3d of_pixel(const auto& seen) {
  const Eigen::Vector2d sigmas = seen.sigmas_px();
  return {sigmas.x(), sigmas.y(), sigmas.x()};
}

// The given sigma on the axes of the group.
Eigen::Vector3d sigma_of(MeasurementIndex index, const Measurements& given) {
  const Block& block = given.block;
  switch (traits_of(index.group).source) {
    case ObservationSource::kTieImagePoint:
      return of_pixel(block.observations[index.source]);
    case ObservationSource::kControlImagePoint:
      return of_pixel(block.control_observations[index.source]);
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

// Replaces the value of a measurement on the ground by what the fit says.
void heal(const Misfit& one, Block& block) {
  switch (source_of(one)) {
    case ObservationSource::kControlCoordinates:
      axes_of(one.index.group, block.control.at(ControlId{one.index.source}).position_in_world) -=
          axes_of(one.index.group, one.off);
      return;
    case ObservationSource::kPosition:
      axes_of(one.index.group, block.images.at(ImageId{one.index.source}).position->position_in_world) -=
          axes_of(one.index.group, one.off);
      return;
    case ObservationSource::kGeodetic:
      block.geodetic[one.index.source].value -= one.off.x();
      return;
    default:
      return;
  }
}

class Chooser {
 public:
  Chooser(const Measurements& given, const ExamineOptions& options, const Run& run)
      : given_(given), at_fit_(given), options_(options), run_(run) {
    options_.reliability = true;
  }

  std::optional<GrossChoice> choose(std::size_t most) {
    const Result<RobustFit> fit = robust_fit(given_, options_.adjust, run_);
    if (!fit) return std::nullopt;
    at_fit_.block.poses = fit->measurements.block.poses;
    at_fit_.block.points = fit->measurements.block.points;
    at_fit_.block.cameras = fit->measurements.block.cameras;
    std::vector<Misfit> gross = gross_misfits(*fit);
    out_.contradiction = contradict_each_other(*fit);
    if (out_.contradiction) {
      out_.remaining.measurements = given_;
      return std::move(out_);
    }
    std::erase_if(gross, [](const Misfit& one) { return source_of(one) == ObservationSource::kAttitude; });
    if (gross.empty()) return std::nullopt;
    if (gross.size() > most) gross.resize(most);
    for (const Misfit& one : gross)
      if (has_no_test(one))
        reject(one);
      else
        on_ground_.push_back(one);
    if (!decide()) return std::nullopt;
    out_.remaining.measurements = without(at_fit_, rejected_);
    return std::move(out_);
  }

 private:
  // An image point, or a fixed coordinate.
  [[nodiscard]] bool has_no_test(const Misfit& one) const {
    return is_image_point(one.index.group) ||
           (axes_of(one.index.group, sigma_of(one.index, given_)).array() == 0).all();
  }

  void reject(const Misfit& one) {
    out_.remaining.rejections.push_back(gross_rejection(one, given_));
    rejected_.push_back(one.index);
    if (source_of(one) == ObservationSource::kTieImagePoint) reject_last_ray(one);
  }

  // Of a tie point with two rays both go.
  void reject_last_ray(const Misfit& one) {
    std::vector<MeasurementIndex> others;
    const auto& rays = given_.block.observations;
    const auto of_point = std::ranges::equal_range(rays, one.measurement.point, {}, &Observation::point);
    for (auto ray = of_point.begin(); ray != of_point.end(); ++ray)
      if (const auto i = static_cast<std::uint32_t>(ray - rays.begin()); i != one.index.source)
        others.push_back({one.index.group, i});
    if (others.size() != 1) return;
    out_.remaining.rejections.back().rejected.as_pair = std::isfinite(one.sigmas);
    rejected_.push_back(others.front());
  }

  // False when there are no tests.
  bool decide() {
    if (on_ground_.empty()) return true;
    Measurements healed = at_fit_;
    for (const Misfit& one : on_ground_) heal(one, healed.block);
    healed = without(std::move(healed), rejected_);
    const Result<Examined> with = examine(healed.block, healed.scope, options_, run_);
    if (!with || !with->reliability) return false;
    for (std::size_t i = 0; i < on_ground_.size(); ++i) {
      const Misfit& one = on_ground_[i];
      if (i < kMostOnGround && is_certain(one, healed, *with)) {
        reject(one);
        test(*with, out_.remaining.rejections.back());
      } else {
        out_.undecided.push_back(one);
      }
    }
    return true;
  }

  // The standard deviation of a gross error by an adjustment without any.
  [[nodiscard]] static double spread_of(const TestedObservation& one, const Reliability& tests) {
    return one.minimal_detectable_bias / tests.delta0;
  }

  // What the tests say of a rejected measurement, its misfit being no part of them.
  void test(const Examined& healed, Rejection& rejection) const {
    Rejected& rejected = rejection.rejected;
    for (const TestedObservation& one : healed.reliability->others) {
      if (one.axis != rejected.axis ||
          measurement_at({one.group, one.source}, given_.block) != static_cast<const Measurement&>(rejected))
        continue;
      const double spread = spread_of(one, *healed.reliability), sigma0 = sigma_scale(healed);
      const double relative = spread / one.sigma;
      rejection.cofactor = std::max(0.0, (relative * relative - 1) / (sigma0 * sigma0));
      rejected.w = rejected.gross_error[one.axis] / spread;
      rejected.redundancy = one.redundancy;
      rejected.influence = (1 - one.redundancy) * rejected.gross_error[one.axis];
    }
  }

  // Nothing else may be wrong in its place.
  bool is_certain(const Misfit& one, const Measurements& healed, const Examined& with) {
    const Reliability& tests = *with.reliability;
    const TestedObservation* const worst = test_of(one, tests);
    if (!worst || !std::isfinite(worst->minimal_detectable_bias)) {
      if (worst) keep(*worst, StayReason::kTooLittleChecks);
      return false;
    }
    const MeasurementIndex index[] = {one.index};
    const Measurements left = without(healed, index);
    const Result<Examined> adjusted = examine(left.block, left.scope, options_, run_);
    if (!adjusted || !adjusted->reliability || adjusted->rank_defect > with.rank_defect) {
      keep(*worst, StayReason::kBlockNeedsIt);
      return false;
    }
    const double w = std::abs(one.off[worst->axis]) / spread_of(*worst, tests);
    std::map<std::pair<Measurement, int>, double> before;
    for (const TestedObservation& other : tests.others) before[{named(other, healed), other.axis}] = other.redundancy;
    bool certain = true;
    for (const TestedObservation& other : adjusted->reliability->others) {
      if (is_image_point(other.group) || named(other, healed) == one.measurement) continue;
      const double redundancy = before[{named(other, healed), other.axis}];
      if (!(redundancy > 1e-6)) continue;
      const double rho = std::sqrt(std::max(0.0, 1 - other.redundancy / redundancy));
      const bool is_poor =
          worst->redundancy < kPoorRedundancy && w * (1 - rho) < tests.limit * std::sqrt(2 * (1 - rho));
      if (!(is_poor || rho > kSame) || !fits_instead(other, one, *adjusted)) continue;
      if (certain) keep(with_misfit(*worst, one.off[worst->axis], w), StayReason::kSameDegree);
      keep(other, StayReason::kSameDegree);
      certain = false;
    }
    return certain;
  }

  [[nodiscard]] static Measurement named(const TestedObservation& one, const Measurements& all) {
    return measurement_at({one.group, one.source}, all.block);
  }

  // Its axis of the largest misfit.
  [[nodiscard]] static const TestedObservation* test_of(const Misfit& one, const Reliability& tests) {
    const TestedObservation* worst = nullptr;
    for (const TestedObservation& test : tests.others)
      if (test.group == one.index.group && test.source == one.index.source &&
          (!worst || std::abs(one.off[test.axis]) > std::abs(one.off[worst->axis])))
        worst = &test;
    return worst;
  }

  // An adjustment with the gross error, and without the other in its place, fits as well as that without it.
  [[nodiscard]] bool fits_instead(const TestedObservation& other, const Misfit& one, const Examined& adjusted) const {
    std::vector<MeasurementIndex> indices = rejected_;
    for (const Misfit& gross : on_ground_)
      if (gross.measurement != one.measurement) indices.push_back(gross.index);
    indices.push_back({other.group, other.source});
    const Measurements left = without(at_fit_, indices);
    const Result<Adjusted> instead = adjust(left.block, left.scope, options_.adjust, run_);
    const double variance = std::max(1.0, adjusted.sigma0 * adjusted.sigma0);
    return instead && instead->converged && instead->final_cost < adjusted.final_cost + kFitsAsWell * variance;
  }

  // Its test with the gross error.
  [[nodiscard]] static TestedObservation with_misfit(TestedObservation one, double off, double w) {
    one.gross_error = off;
    one.residual = one.redundancy * off;
    one.w = one.suspicion = std::copysign(w, off);
    return one;
  }

  void keep(const TestedObservation& one, StayReason reason) { out_.kept.push_back({one, reason}); }

  const Measurements& given_;
  Measurements at_fit_;
  ExamineOptions options_;
  const Run& run_;
  std::vector<Misfit> on_ground_;
  std::vector<MeasurementIndex> rejected_;
  GrossChoice out_;
};

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

std::optional<GrossChoice> choose_gross(const Measurements& given, const ExamineOptions& options, int most,
                                        const Run& run) {
  return Chooser(given, options, run).choose(static_cast<std::size_t>(std::max(0, most)));
}

}  // namespace collinea
