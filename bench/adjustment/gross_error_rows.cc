// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "blocks.h"
#include "collinea/quality/snooping.h"
#include "gross_error_counts.h"
#include "rows.h"

namespace collinea::bench {
namespace {

using Group = ObservationGroup;

constexpr double kShare = 0.01;  // of image points

// What was planted: rays of tie points by (image, point), rays of control and coordinates of control.
struct Planted {
  std::set<std::pair<ImageId, PointId>> rays;
  std::set<PointId> points;
  std::set<std::pair<ImageId, ControlId>> control_rays;
  std::set<std::pair<ControlId, Group>> coordinates;
};

class Trial {
 public:
  Trial(const Block& clean, const Examined& adjusted, std::uint64_t seed)
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
      const double redundancy = tests_.tie_redundancy[i][axis], sigmas = gross_error();
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
    double sigmas = gross_error();
    seen.pixel[ray.axis] += sigmas * seen.sigma_px;
    planted.control_rays.insert({seen.image, seen.point});
    counts.plant(sigmas, ray.redundancy, tests_.limit);
    const TestedObservation* ground = nullptr;
    do {
      ground = &on_ground[random_.below(static_cast<std::uint32_t>(on_ground.size()))];
    } while (ground->source == seen.point.value);
    ControlPoint& point = block.control.at(ControlId{ground->source});
    sigmas = gross_error();
    point.position_in_world[ground->axis] += sigmas * point.sigma_m[ground->axis];
    planted.coordinates.insert({ControlId{ground->source}, ground->group});
    counts.plant(sigmas, ground->redundancy, tests_.limit);
  }
  double gross_error() {
    return (random_.uniform() < 0.5 ? -1 : 1) * random_.uniform(kMinimalDetectableBias, kLargestGrossError);
  }

  const Reliability& tests_;
  const Examined& adjusted_;
  Random random_;
};

// Of the errors of places in units of their covariances, over its freedom.
double mean_length(const Examined& adjusted, const Block& exact) {
  double sum = 0;
  for (const auto& [id, covariance] : adjusted.pose_covariance) {
    const Eigen::Vector3d by = centre_of(adjusted.cam_from_world.at(id)) - centre_of(pose_of(exact, id));
    sum += by.dot(covariance.bottomRightCorner<3, 3>().inverse() * by) / 3;
  }
  return sum / static_cast<double>(adjusted.pose_covariance.size());
}

// The block without what is going to be planted: as snooping leaves it that finds all of it and nothing else.
Block without(Block block, const Planted& planted) {
  std::erase_if(block.observations, [&](const Observation& seen) {
    return planted.rays.contains({seen.image, seen.point});
  });
  std::erase_if(block.control_observations, [&](const ControlObservation& seen) {
    return planted.control_rays.contains({seen.image, seen.point});
  });
  for (const auto& [id, group] : planted.coordinates) {
    Eigen::Vector3d& sigma = block.control.at(id).sigma_m;
    if (group == Group::kControlHeight)
      sigma.z() = std::numeric_limits<double>::infinity();
    else
      sigma.head<2>().setConstant(std::numeric_limits<double>::infinity());
  }
  return block;
}

double mean_of(const std::vector<double>& all) {
  double sum = 0;
  for (const double one : all) sum += one;
  return sum / static_cast<double>(all.size());
}

}  // namespace

Rows gross_errors(const Effort& effort, const Run& run) {
  Counts rays, control;
  double tested = 0, false_alarms = 0, rounds = 0;
  // Of each block: what snooping does to the lengths of errors, and the square of what it may do, because measurements
  // have gone. Its own scatter would allow for what it spoils.
  std::vector<double> lengthened, allowed;
  int failed = 0;
  ExamineOptions options = exact_options(Calibration::kBrown);
  options.reliability = true;
  for (int i = 0; i < effort.gross_error_blocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(5000 + i);
    const Measured made = measured(exact_block(static_cast<Layout>(i % 3), {.points = 300, .control = 9}, seed), seed);
    const auto clean = examine(made.block, made.scope, options, run);
    if (!clean || !clean->reliability) {
      ++failed;
      continue;
    }
    Trial trial(made.block, *clean, seed);
    trial.plant(rays, control);
    const auto snooped = snoop(trial.block, made.scope, options, kMostRejected, run);
    const auto best = examine(without(made.block, trial.planted), made.scope, options, run);
    if (!best || !snooped || !snooped->finished || !snooped->adjusted.reliability) {
      ++failed;
      continue;
    }
    tested += static_cast<double>(clean->reliability->tested);
    rounds = std::max(rounds, static_cast<double>(snooped->rounds));
    for (const Rejected& rejected : snooped->rejected) {
      bool right = false;
      if (rejected.group == Group::kTieImages) {
        right = trial.planted.rays.contains({rejected.image, rejected.point}) ||
                (rejected.as_pair && trial.planted.points.contains(rejected.point));
        rays.found += right;
      } else {
        right = rejected.group == Group::kControlImages
                    ? trial.planted.control_rays.contains({rejected.image, rejected.control})
                    : trial.planted.coordinates.contains({rejected.control, rejected.group});
        control.found += right;
      }
      if (!right) ++false_alarms;
    }
    // What is left is as true as a block without blunders.
    const Block exact = exact_block(static_cast<Layout>(i % 3), {.points = 1, .control = 0}, seed);
    const double all = mean_length(*clean, exact);
    lengthened.push_back(mean_length(snooped->adjusted, exact) - all);
    allowed.push_back(std::pow(mean_length(*best, exact) - all, 2));
  }
  const double mean = mean_of(lengthened),
               deviation = std::sqrt(mean_of(allowed) / static_cast<double>(allowed.size()));
  const double level = options.test.false_alarm, expected = level * tested;
  return {rays.row("blunders of 4-20 sigma in 1 % of image points, snooped"),
          control.row("blunders of 4-20 sigma in control, images and coordinates"),
          {fmt::format("false alarms at a level of {:g}", level), "as stated, within 4 binomial deviations",
           fmt::format("{:.0f} of {:.0f} tests; expected {:.1f} +- {:.1f}", false_alarms, tested, expected,
                       std::sqrt(expected)),
           std::abs(false_alarms - expected) < 4 * std::sqrt(expected)},
          {"places of images after snooping",
           "chi-squared / freedom as of the same blocks without blunders, within 4 deviations of taking out what was "
           "planted and nothing else",
           fmt::format("differs by {:+.3f} +- {:.3f}", mean, deviation), std::abs(mean) < 4 * deviation},
          {"snooping ends", "in all blocks",
           fmt::format("{} of {} not; at most {:.0f} rounds", failed, effort.gross_error_blocks, rounds), failed == 0}};
}

}  // namespace collinea::bench
