// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "blocks.h"
#include "collinea/adjust/survey_block.h"
#include "collinea/geometry/rotation.h"
#include "collinea/quality/snooping.h"
#include "collinea/report/finding_words.h"
#include "gross_error_counts.h"
#include "rows.h"

namespace collinea::bench {
namespace {

using Group = ObservationGroup;

const Eigen::Vector3d kUnknown = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
constexpr double kLength_m = 0.005, kAngle_rad = 1e-4;  // a good total station over a hundred metres

bool is_geodetic(Group group) { return group >= Group::kDistance && group <= Group::kOnLine; }
bool is_attitude(Group group) { return group >= Group::kAttitudeLevel; }

// Attitudes of an inertial system, turned by its boresight.
void add_attitudes(const Block& exact, const Eigen::Vector3d& boresight, AdjustScope& scope, Random& random) {
  const Eigen::Vector3d sigma(3e-4, 3e-4, 6e-4);
  for (const auto& [id, pose] : oriented_images(exact))
    scope.attitudes[id] = {
        (rotation_by(boresight).conjugate() * pose.rotation * rotation_by(sigma.cwiseProduct(normal3(random))))
            .normalized(),
        sigma};
  scope.boresight_sigma_rad[{1}] = kUnknown;
}

}  // namespace

Rows survey_gross_errors(const Effort& effort, const Run& run) {
  std::map<bool, Counts> counts;  // of attitudes: true
  double alarms = 0, good = 0;
  int failed = 0;
  ExamineOptions options = exact_options(Calibration::kFocalRadial);
  options.reliability = true;
  options.test.false_alarm =
      0.005;  // so that enough of these few measurements are wrongly doubted to see that none are
  for (int i = 0; i < effort.gross_error_blocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(8000 + i);
    const Block exact = exact_block(Layout::kCrossStrips, {.points = 150, .control = 8}, seed);
    Measured made = measured(exact, seed);
    Random random(seed, 31);
    std::vector<ControlId> ids;
    for (const auto& [id, control] : exact.control) ids.push_back(id);
    testing::measure_geodetic(exact, made.block, ids, kLength_m, kAngle_rad, random);
    add_attitudes(exact, {0.01, -0.02, 0.03}, made.scope, random);
    const auto clean = examine(made.block, made.scope, options, run);
    if (!clean || !clean->reliability) {
      ++failed;
      continue;
    }
    std::set<std::pair<Group, std::uint32_t>> wrong;
    for (const bool attitude : {false, true}) {
      std::vector<TestedObservation> all;
      for (const TestedObservation& one : clean->reliability->others)
        if (one.redundancy > 0.1 && (attitude ? is_attitude(one.group) : is_geodetic(one.group))) all.push_back(one);
      for (int planted = 0; planted < 2;) {
        const TestedObservation& one = all[random.below(static_cast<std::uint32_t>(all.size()))];
        if (!wrong.insert({one.group, one.source}).second) continue;
        const double sigmas =
            (random.uniform() < 0.5 ? -1 : 1) * random.uniform(kMinimalDetectableBias, kLargestGrossError);
        if (attitude) {
          Eigen::Quaterniond& given = made.scope.attitudes.at(ImageId{one.source}).cam_from_world;
          given = (given * rotation_by(sigmas * one.sigma * Eigen::Vector3d::Unit(one.axis))).normalized();
        } else {
          made.block.geodetic[one.source].value += sigmas * one.sigma;
        }
        counts[attitude].plant(sigmas, one.redundancy, clean->reliability->limit);
        ++planted;
      }
    }
    const auto snooped = snoop(made.block, made.scope, options, kMostRejected, run);
    if (!snooped || !snooped->finished) {
      ++failed;
      continue;
    }
    for (const Rejected& rejected : snooped->rejected) {
      if (!is_geodetic(rejected.group) && !is_attitude(rejected.group)) continue;
      const bool attitude = is_attitude(rejected.group);
      const bool right = wrong.contains({rejected.group, attitude ? rejected.image.value : rejected.geodetic});
      (right ? counts[attitude].found : alarms) += 1;
    }
    good += static_cast<double>(3 * made.scope.attitudes.size() + made.block.geodetic.size());
  }
  const double expected = options.test.false_alarm * good;
  return {counts[false].row("blunders of 4-20 sigma in measurements on the ground, snooped"),
          counts[true].row("blunders of 4-20 sigma in attitudes, snooped"),
          {fmt::format("false alarms among these at a level of {:g}", options.test.false_alarm),
           "as stated, within 4 binomial deviations",
           fmt::format("{:.0f} of {:.0f} tests; expected {:.1f} +- {:.1f}; {} blocks failed", alarms, good, expected,
                       std::sqrt(expected), failed),
           failed == 0 && std::abs(alarms - expected) < 4 * std::sqrt(expected) + 0.5}};
}

namespace {

const Eigen::Vector3d kArm(0.3, -0.2, -0.5), kShift(0.4, -0.7, 1.1), kDrift(0.03, -0.02, 0.05),
    kRotation(0.02, -0.015, 0.03);

// Strips without any across, each with a shift of its own, and no control: nothing parts the shifts from the block.
Row without_cross_flight(const Run& run) {
  Block exact = exact_block(Layout::kCrossStrips, {.points = 300, .control = 4}, 4);
  for (const auto& [id, pose] : oriented_images(exact))
    if (id.value > 18) remove_pose(exact, id);
  std::erase_if(exact.observations, [](const auto& seen) { return seen.image.value > 18; });
  std::erase_if(exact.control_observations, [](const auto& seen) { return seen.image.value > 18; });
  Measured made = measured(exact, 4);
  for (std::uint32_t strip = 0; strip < 3; ++strip) {
    PositionTrack track;
    for (std::uint32_t i = 0; i < 6; ++i) track.time[ImageId{6 * strip + i + 1}] = i - 2.5;
    track.shift_sigma_m = Eigen::Vector3d::Constant(10);
    made.scope.position_tracks.push_back(track);
  }
  made.scope.use_control = false;
  ExamineOptions options = exact_options(Calibration::kNone);
  const auto adjusted = examine(made.block, made.scope, options, run);
  Row row{"strips without cross flight, each with a shift", "the correlation is named, with its cure",
          adjusted ? "not named" : adjusted.error().message};
  if (adjusted && !adjusted->inseparable.empty()) {
    row.measured = sentence_of(adjusted->inseparable.front(), made.block);
    row.ok = row.measured.find("shift") != std::string::npos && row.measured.find("cross") != std::string::npos;
  }
  return row;
}

}  // namespace

Rows instruments(const Effort& effort, const Run& run) {
  struct Found {
    const char* name;
    Eigen::Vector3d truth;
    double squares = 0, beyond = 0, all = 0, sigma = 0;
  };
  std::map<UnknownKind, Found> found = {{UnknownKind::kLeverArm, {"lever arm [m]", kArm}},
                                        {UnknownKind::kShift, {"shift [m]", kShift}},
                                        {UnknownKind::kDrift, {"drift [m an image]", kDrift}},
                                        {UnknownKind::kBoresight, {"boresight [rad]", kRotation}}};
  int failed = 0;
  for (int i = 0; i < effort.gross_error_blocks; ++i) {
    const auto seed = static_cast<std::uint64_t>(9000 + i);
    const Block exact = exact_block(Layout::kCrossStrips, {.points = 200, .control = 8}, seed);
    Measured made = measured(exact, seed);
    Random random(seed, 32);
    PositionTrack track;
    track.shift_sigma_m = track.drift_sigma_m = kUnknown;
    double time = -0.5 * static_cast<double>(made.block.images.size());
    for (auto& [id, image] : made.block.images) {
      image.position->position_in_world += pose_of(exact, id).rotation.conjugate() * kArm + kShift + time * kDrift;
      track.time[id] = time++;
    }
    made.scope.position_tracks.push_back(track);
    made.scope.lever_arms[{1}] = {Eigen::Vector3d::Zero(), kUnknown};
    add_attitudes(exact, kRotation, made.scope, random);
    ExamineOptions options = exact_options(Calibration::kFocalRadial);
    const auto adjusted = examine(made.block, made.scope, options, run);
    if (!adjusted || adjusted->undetermined) {
      ++failed;
      continue;
    }
    for (const EstimatedUnknown& one : adjusted->auxiliaries) {
      Found& its = found.at(one.kind);
      const double sigma = one.sigma * sigma_scale(*adjusted), t = (one.value - its.truth[one.axis]) / sigma;
      its.squares += t * t;
      its.beyond += std::abs(t) > 3;
      ++its.all;
      its.sigma += sigma;
    }
  }
  Rows rows;
  for (const auto& [kind, its] : found) {
    constexpr double kBeyond3 = 0.0027;
    const double chance = kBeyond3 * its.all, mean = its.squares / its.all, deviation = std::sqrt(2 / its.all);
    rows.push_back({fmt::format("{} found again", its.name),
                    "within 3 sigma, but for 0.3 % of chance; errors over sigmas: mean square 1 within 4 deviations",
                    fmt::format("{:.0f} of {:.0f} beyond 3 sigma (of {:.2g} on average); {:.2f} +- {:.2f}", its.beyond,
                                its.all, its.sigma / its.all, mean, deviation),
                    failed == 0 && its.beyond <= chance + 4 * std::sqrt(chance) && std::abs(mean - 1) < 4 * deviation});
  }
  rows.push_back(without_cross_flight(run));
  return rows;
}

}  // namespace collinea::bench
