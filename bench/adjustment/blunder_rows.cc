// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "blocks.h"
#include "blunder_counts.h"
#include "collinea/adjust/snooping.h"
#include "rows.h"

namespace collinea::bench {
namespace {

using Group = ObservationGroup;

constexpr double kShare = 0.01;  // of image points
// By how much the mean squared length of errors of a block's places differs when a hundredth of its rays has gone, as a
// standard deviation over blocks: measured where snooping is right. Its own scatter would allow for what it spoils.
constexpr double kOfBlock = 0.18;

// What was planted: rays of tie points by (image, point), rays of control and coordinates of control.
struct Planted {
  std::set<std::pair<ImageId, PointId>> rays;
  std::set<PointId> points;
  std::set<std::pair<ImageId, ControlId>> control_rays;
  std::set<std::pair<ControlId, Group>> coordinates;
};

class Trial {
 public:
  Trial(const Block& clean, const Adjusted& adjusted, std::uint64_t seed)
      : block(clean), tests_(*adjusted.reliability), adjusted_(adjusted), random_(seed, 5) {}

  Block block;
  Planted planted;

  void plant(Counts& rays, Counts& control) {
    const std::size_t all = adjusted_.observations.size();
    const auto wanted = static_cast<std::size_t>(kShare * static_cast<double>(all));
    while (planted.rays.size() < wanted) {
      const std::size_t i = random_.below(static_cast<std::uint32_t>(all));
      Observation& seen = block.observations[adjusted_.observations[i]];
      const int axis = static_cast<int>(random_.below(2));
      const double redundancy = tests_.tie_redundancy[i][axis], sigmas = blunder();
      if (!planted.points.insert(seen.point).second) continue;
      planted.rays.insert({seen.image, seen.point});
      seen.pixel[axis] += sigmas * seen.sigma_px;
      rays.plant(sigmas, redundancy, tests_.limit);
    }
    plant_in_control(control);
  }

 private:
  // One ray of a control point and a coordinate of another.
  void plant_in_control(Counts& counts) {
    std::vector<TestedObservation> in_images, on_ground;
    for (const TestedObservation& one : tests_.others) {
      if (one.redundancy < 0.1) continue;
      if (one.group == Group::kControlImages) in_images.push_back(one);
      if (one.group == Group::kControlPlan || one.group == Group::kControlHeight) on_ground.push_back(one);
    }
    const TestedObservation& ray = in_images[random_.below(static_cast<std::uint32_t>(in_images.size()))];
    ControlObservation& seen = block.control_observations[ray.source];
    double sigmas = blunder();
    seen.pixel[ray.axis] += sigmas * seen.sigma_px;
    planted.control_rays.insert({seen.image, seen.point});
    counts.plant(sigmas, ray.redundancy, tests_.limit);
    const TestedObservation* ground = nullptr;
    do {
      ground = &on_ground[random_.below(static_cast<std::uint32_t>(on_ground.size()))];
    } while (ground->source == seen.point.value);
    ControlPoint& point = block.control.at(ControlId{ground->source});
    sigmas = blunder();
    point.position_in_world[ground->axis] += sigmas * point.sigma_m[ground->axis];
    planted.coordinates.insert({ControlId{ground->source}, ground->group});
    counts.plant(sigmas, ground->redundancy, tests_.limit);
  }
  double blunder() { return (random_.uniform() < 0.5 ? -1 : 1) * random_.uniform(kLeastBlunder, kLargestBlunder); }

  const Reliability& tests_;
  const Adjusted& adjusted_;
  Random random_;
};

// Of the errors of places in units of their covariances, over its freedom.
double mean_length(const Adjusted& adjusted, const Block& exact) {
  double sum = 0;
  for (const auto& [id, covariance] : adjusted.pose_covariance) {
    const Eigen::Vector3d by = centre_of(adjusted.cam_from_world.at(id)) - centre_of(exact.cam_from_world.at(id));
    sum += by.dot(covariance.bottomRightCorner<3, 3>().inverse() * by) / 3;
  }
  return sum / static_cast<double>(adjusted.pose_covariance.size());
}

}  // namespace

Rows blunders(const Effort& effort, const Run& run) {
  Counts rays, control;
  double tested = 0, false_alarms = 0, rounds = 0;
  std::vector<double> lengthened;  // of each block
  int failed = 0;
  AdjustOptions options = exact_options("brown");
  options.reliability = true;
  for (int i = 0; i < effort.blunder_blocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(5000 + i);
    const Measured made = measured(exact_block(static_cast<Layout>(i % 3), {.points = 300, .control = 9}, seed), seed);
    const auto clean = adjust(made.block, made.scope, options, run);
    if (!clean || !clean->reliability) {
      ++failed;
      continue;
    }
    Trial trial(made.block, *clean, seed);
    trial.plant(rays, control);
    const auto snooped = snoop(trial.block, made.scope, options, kMostTakenOut, run);
    if (!snooped || !snooped->finished || !snooped->adjusted.reliability) {
      ++failed;
      continue;
    }
    tested += static_cast<double>(clean->reliability->tested);
    rounds = std::max(rounds, static_cast<double>(snooped->rounds));
    for (const TakenOut& gone : snooped->taken_out) {
      bool right = false;
      if (gone.group == Group::kTieImages) {
        right = trial.planted.rays.contains({gone.image, gone.point}) ||
                (gone.as_pair && trial.planted.points.contains(gone.point));
        rays.found += right;
      } else {
        right = gone.group == Group::kControlImages ? trial.planted.control_rays.contains({gone.image, gone.control})
                                                    : trial.planted.coordinates.contains({gone.control, gone.group});
        control.found += right;
      }
      if (!right) ++false_alarms;
    }
    // What is left is as true as a block without blunders.
    const Block exact = exact_block(static_cast<Layout>(i % 3), {.points = 1, .control = 0}, seed);
    lengthened.push_back(mean_length(snooped->adjusted, exact) - mean_length(*clean, exact));
  }
  double mean = 0;
  for (const double one : lengthened) mean += one / static_cast<double>(lengthened.size());
  const double deviation = kOfBlock / std::sqrt(static_cast<double>(std::max<std::size_t>(1, lengthened.size())));
  const double level = options.false_alarm, expected = level * tested;
  return {rays.row("blunders of 4-20 sigma in 1 % of image points, snooped"),
          control.row("blunders of 4-20 sigma in control, images and coordinates"),
          {fmt::format("false alarms at a level of {:g}", level), "as stated, within 4 binomial deviations",
           fmt::format("{:.0f} of {:.0f} tests; expected {:.1f} +- {:.1f}", false_alarms, tested, expected,
                       std::sqrt(expected)),
           std::abs(false_alarms - expected) < 4 * std::sqrt(expected)},
          {"places of images after snooping",
           "chi-squared / freedom as of the same blocks without blunders, within 4 deviations of 0.18 a block",
           fmt::format("differs by {:+.3f} +- {:.3f}", mean, deviation), std::abs(mean) < 4 * deviation},
          {"snooping ends", "in all blocks",
           fmt::format("{} of {} not; at most {:.0f} rounds", failed, effort.blunder_blocks, rounds), failed == 0}};
}

}  // namespace collinea::bench
