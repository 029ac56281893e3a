// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/internal/suspect_choice.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>

namespace collinea {
namespace {

constexpr double kControllableRedundancy = 0.01;  // Foerstner: below it nothing shows a gross error
constexpr int kLeastRaysOfImage = 6;              // twice what orients it
constexpr double kSpoiltByRay = 10;               // over the rays of an image: share of w by which one spoils another

// Rays that take part.
struct RayCounts {
  std::map<ImageId, int> of_image;
  std::map<PointId, int> of_point;  // tie points
};

// A pass over the suspects: what it has met so far, all of it worse than what comes.
struct Pass {
  RayCounts rays;                            // left when what was chosen is gone
  std::map<ImageId, double> worse_in_image;  // sum of |w|
  std::set<PointId> points;                  // with a suspect ray
  std::set<ControlId> controls;              // the same
  std::set<ControlId> doubtful;              // of which something that is no image point stays
  std::set<Measurement> chosen;
  bool others_met = false;  // a suspect that is no image point and might go
  bool others_stay = false;
};

// Only what takes part keeps an image where it is.
RayCounts count_rays(const Examined& adjusted, const Block& block) {
  RayCounts rays;
  for (const std::uint32_t i : adjusted.observations) {
    const Observation& seen = block.observations[i];
    ++rays.of_image[seen.image];
    ++rays.of_point[seen.point];
  }
  for (const TestedObservation& one : adjusted.reliability->others)
    if (is_image_point(one.group) && one.axis == 0)
      ++rays.of_image[measurement_at({one.group, one.source}, block).image];
  return rays;
}

std::optional<StayReason> reason_to_stay(const TestedObservation& one, const Measurement& measurement,
                                         const StayReasons& stays, const Pass& pass) {
  if (const auto known = stays.find(measurement); known != stays.end()) return known->second;
  if (!std::isfinite(one.w)) return std::nullopt;
  const bool in_image = is_image_point(one.group);
  if (one.redundancy < (in_image || pass.others_stay ? kPoorRedundancy : kControllableRedundancy))
    return StayReason::kTooLittleChecks;
  if (in_image && pass.rays.of_image.at(measurement.image) <= kLeastRaysOfImage) return StayReason::kImageNeedsIt;
  return std::nullopt;
}

// An image point waits for the next round when worse ones of its image or its point may have spoilt it.
bool image_point_waits(const TestedObservation& one, const Measurement& measurement, double limit, Pass& pass) {
  double& worse = pass.worse_in_image[measurement.image];
  const double spoilt = worse * std::min(1.0, kSpoiltByRay / pass.rays.of_image[measurement.image]);
  const bool is_explained = std::isfinite(one.w) && std::abs(one.w) - spoilt < limit;
  const bool is_first = measurement.point.valid() ? pass.points.insert(measurement.point).second
                                                  : pass.controls.insert(measurement.control).second;
  if (std::isfinite(one.w)) worse += std::abs(one.w);
  return is_explained || !is_first;
}

// All others wait for the worst of them, and for worse rays of their control points.
bool other_waits(const Measurement& measurement, const Block& block, Pass& pass) {
  const std::set<ControlId> its = control_points_of(measurement, block);
  const bool waits =
      pass.others_met || std::ranges::any_of(its, [&](ControlId id) { return pass.controls.contains(id); });
  pass.others_met = true;
  return waits;
}

// The other rays of the tie point of one; observations are sorted by point.
std::vector<MeasurementIndex> other_rays(MeasurementIndex index, const Block& block) {
  const std::vector<Observation>& all = block.observations;
  const auto of_point = std::ranges::equal_range(all, all[index.source].point, {}, &Observation::point);
  std::vector<MeasurementIndex> others;
  for (auto ray = of_point.begin(); ray != of_point.end(); ++ray)
    if (const auto i = static_cast<std::uint32_t>(ray - all.begin()); i != index.source)
      others.push_back({index.group, i});
  return others;
}

void choose(const TestedObservation& one, const Measurement& measurement, const Block& block, Pass& pass,
            SuspectChoice& choice) {
  ChosenSuspect suspect{one, measurement};
  if (is_image_point(one.group)) --pass.rays.of_image[measurement.image];
  // A point with one ray is none.
  if (measurement.point.valid() && --pass.rays.of_point[measurement.point] < 2) {
    suspect.as_pair = std::isfinite(one.w);
    for (const MeasurementIndex& ray : other_rays({one.group, one.source}, block)) {
      choice.last_rays.push_back(ray);
      --pass.rays.of_image[block.observations[ray.source].image];
    }
  }
  pass.chosen.insert(measurement);
  choice.suspects.push_back(suspect);
}

}  // namespace

SuspectChoice choose_suspects(const Examined& adjusted, const Block& block, const StayReasons& stays,
                              const ChoiceBounds& bounds) {
  const Reliability& tests = *adjusted.reliability;
  Pass pass{.rays = count_rays(adjusted, block)};
  SuspectChoice choice;
  for (const TestedObservation& one : tests.suspects) {
    const bool in_image = is_image_point(one.group);
    const Measurement measurement = measurement_at({one.group, one.source}, block);
    if (pass.chosen.contains(measurement)) continue;  // its other coordinate
    if (const auto reason = reason_to_stay(one, measurement, stays, pass)) {
      choice.kept.push_back({one, *reason});
      if (!in_image) {
        pass.others_stay = true;
        pass.doubtful.merge(control_points_of(measurement, block));
      }
      continue;
    }
    if (in_image && pass.others_met) continue;  // what is worse may have spoilt it
    if (in_image && pass.doubtful.contains(measurement.control)) {
      choice.kept.push_back({one, StayReason::kWorseOfItsPoint});
      continue;
    }
    if (in_image ? image_point_waits(one, measurement, one.limit, pass) : other_waits(measurement, block, pass))
      continue;
    choice.bound_is_reached = static_cast<int>(choice.suspects.size()) >= bounds.in_all;
    if (choice.bound_is_reached || choice.suspects.size() == bounds.of_round) break;
    if (!in_image) choice.rivals = rivals_of(one, tests, block);
    choose(one, measurement, block, pass, choice);
  }
  return choice;
}

}  // namespace collinea
