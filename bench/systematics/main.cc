// SPDX-License-Identifier: Apache-2.0
// Systematic errors of known size in simulated flights: how often each is detected against the power of theory, how
// often anything is named where there is nothing, whether estimates are within their sigmas, and check points before
// and after an error of an instrument is taken up. Tables for docs/theory/systematics.md.
//
// usage: collinea_bench_systematics [blocks [threads]]
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "collinea/base/parallel.h"
#include "collinea/math/fisher.h"
#include "collinea/quality/test_flight.h"

namespace collinea {
namespace {

using testing::FlightOptions;
using testing::Flown;
using testing::Wrong;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Case {
  const char* name;
  SystematicKind kind;
  Wrong wrong;
  FlightOptions flight = {};
  int strip = -1;
  AdditionalSet set = AdditionalSet::kNone;
};

// The chance that chi-squared with q degrees of freedom and that noncentrality exceeds a limit: a Poisson mixture.
double noncentral_tail(double limit, int q, double noncentrality) {
  const double half = noncentrality / 2;
  double weight = std::exp(-half), sum = 0;
  for (int j = 0; j < 400; ++j) {
    sum += weight * fisher_tail(limit / (q + 2 * j), q + 2 * j, kInfinity);
    weight *= half / (j + 1);
  }
  return sum;
}

double limit_of(double chance, int q) {
  double low = 0, high = 500;
  for (int i = 0; i < 100; ++i)
    (fisher_tail((low + high) / 2 / q, q, kInfinity) > chance ? low : high) = (low + high) / 2;
  return low;
}

std::vector<SystematicTest> tests_of(const Flown& made, double level) {
  ExamineOptions options = testing::looking_for_systematics(made, Calibration::kNone);
  options.systematics.level = level;
  const auto examined = examine(made.block, made.scope, options, Run{});
  return examined ? examined->systematics : std::vector<SystematicTest>{};
}

const SystematicTest* find(const std::vector<SystematicTest>& tests, const Case& one) {
  const auto its = std::ranges::find_if(tests, [&](const SystematicTest& test) {
    return test.kind == one.kind && test.strip.value_or(-1) == one.strip && test.additional == one.set;
  });
  return its == tests.end() ? nullptr : &*its;
}

struct Outcome {
  bool detected = false, named = false;
  double power = 0, squares = 0, degrees = 0;
};

// The statistic of the same flight without noise is the noncentrality; estimates are compared with those of that
// flight.
Outcome simulate(const Case& one, std::uint64_t seed, double level) {
  FlightOptions exact = one.flight;
  exact.noise = false;
  const std::vector<SystematicTest> truth = tests_of(testing::flown(seed, one.wrong, exact), level);
  const std::vector<SystematicTest> tests = tests_of(testing::flown(seed, one.wrong, one.flight), level);
  const SystematicTest *expected = find(truth, one), *test = find(tests, one);
  if (!test || !expected) return {};
  const auto count = static_cast<double>(tests.size());
  Outcome out{.detected = test->significant, .named = test->significant};
  if (test->explained_by)
    out.named = std::ranges::find(test->indistinguishable, *test->explained_by) != test->indistinguishable.end();
  out.power = noncentral_tail(limit_of(level / count, test->degrees), test->degrees, expected->statistic);
  for (std::size_t k = 0; k < test->values.size(); ++k)
    out.squares += std::pow((test->values[k] - expected->values[k]) / test->sigmas[k], 2);
  out.degrees = static_cast<double>(test->values.size());
  return out;
}

void print_detection(const std::vector<Case>& cases, int blocks, const Run& run) {
  constexpr double kLevel = 0.001;
  fmt::print(
      "| error | detected | power of theory | named | squares of normalised errors over their number |\n"
      "|---|---|---|---|---|\n");
  for (const Case& one : cases) {
    std::vector<Outcome> all(static_cast<std::size_t>(blocks));
    parallel_for(run, all.size(), [&](std::size_t i) { all[i] = simulate(one, 1000 + i, kLevel); });
    double detected = 0, named = 0, power = 0, spread = 0, squares = 0, degrees = 0;
    for (const Outcome& out : all) {
      detected += out.detected;
      named += out.named;
      power += out.power;
      spread += out.power * (1 - out.power);
      squares += out.squares;
      degrees += out.degrees;
    }
    fmt::print("| {} | {:.0f} of {} | {:.1f} +- {:.1f} | {:.0f} | {:.2f} |\n", one.name, detected, blocks, power,
               std::sqrt(spread), named, squares / degrees);
    std::fflush(stdout);
  }
}

void print_false_alarms(int blocks, const Run& run) {
  fmt::print("\n| level | blocks | with anything significant |\n|---|---|---|\n");
  for (const double level : {0.05, 0.01, 0.001}) {
    std::vector<int> alarms(static_cast<std::size_t>(blocks));
    parallel_for(run, alarms.size(), [&](std::size_t i) {
      alarms[i] = std::ranges::any_of(tests_of(testing::flown(5000 + i, {}, {.attitudes = true}), level),
                                      &SystematicTest::significant);
    });
    fmt::print("| {} | {} | {} |\n", level, blocks, std::ranges::count(alarms, 1));
  }
}

// The scope of a second adjustment, by what would be taken up.
AdjustScope with(const InstrumentOptions& taken, const Flown& made) {
  const Eigen::Vector3d free = Eigen::Vector3d::Constant(kInfinity);
  AdjustScope scope = made.scope;
  scope.velocity_m_s = made.systematics.velocity_m_s;
  if (taken.time_offset) scope.time_offset_sigma_s[{1}] = kInfinity;
  if (taken.lever_arm) scope.lever_arms[{1}] = {Eigen::Vector3d::Zero(), free};
  if (taken.position_shift == PositionShift::kNone) return scope;
  if (taken.position_shift == PositionShift::kStrips) {
    for (const auto& strip : made.systematics.strips) scope.position_tracks.push_back({strip, free});
    return scope;
  }
  PositionTrack track{.shift_sigma_m = free};
  for (const auto& [id, image] : made.block.images) track.time[id] = 0;
  scope.position_tracks = {track};
  return scope;
}

struct CheckErrors {
  double plan = 0, height = 0, count = 0;
  bool taken = false;
  void add(const Adjusted& adjusted, const Block& truth) {
    for (const ControlDifference& one : adjusted.control) {
      if (one.used || !one.position_in_world) continue;
      const Eigen::Vector3d d = *one.position_in_world - truth.control.at(one.point).position_in_world;
      plan += d.head<2>().squaredNorm() / 2;
      height += d.z() * d.z();
      ++count;
    }
  }
  void add(const CheckErrors& other) { plan += other.plan, height += other.height, count += other.count; }
};

void print_check_points(const std::vector<Case>& cases, int blocks, const Run& run) {
  fmt::print("\n| error | taken up | plan before, after [m] | height before, after [m] |\n|---|---|---|---|\n");
  for (const Case& one : cases) {
    std::vector<CheckErrors> before(static_cast<std::size_t>(blocks)), after(before.size());
    parallel_for(run, before.size(), [&](std::size_t i) {
      const Flown made = testing::flown(9000 + i, one.wrong, one.flight);
      const ExamineOptions options = testing::looking_for_systematics(made);
      const auto first = examine(made.block, made.scope, options, Run{});
      if (!first) return;
      before[i].add(*first, made.truth);
      const InstrumentOptions taken = taken_up(first->systematics, {});
      before[i].taken = taken.time_offset || taken.lever_arm || taken.position_shift != PositionShift::kNone;
      if (const auto second = adjust(made.block, with(taken, made), options.adjust, Run{}))
        after[i].add(*second, made.truth);
    });
    CheckErrors sums[2];
    for (std::size_t i = 0; i < before.size(); ++i) sums[0].add(before[i]), sums[1].add(after[i]);
    const auto rms = [](double squares, const CheckErrors& of) { return std::sqrt(squares / of.count); };
    fmt::print("| {} | {} of {} | {:.4f}, {:.4f} | {:.4f}, {:.4f} |\n", one.name,
               std::ranges::count(before, true, &CheckErrors::taken), blocks, rms(sums[0].plan, sums[0]),
               rms(sums[1].plan, sums[1]), rms(sums[0].height, sums[0]), rms(sums[1].height, sums[1]));
    std::fflush(stdout);
  }
}

}  // namespace

void print_systematics(int blocks, const Run& run) {
  using K = SystematicKind;
  const FlightOptions turned{.attitudes = true}, free{.control = 0}, coarse{.position_sigma_m = 10};
  const std::vector<Case> cases = {
      {"time offset 2 ms", K::kTimeOffset, {.time_offset_s = 0.002}},
      {"lever arm 1.5, 0, 1.5 cm", K::kLeverArm, {.lever_arm_m = {0.015, 0, 0.015}}},
      {"shift 2, 1, 2 cm", K::kShift, {.shift_m = {0.02, 0.01, 0.02}}},
      {"shift of a strip 3 cm", K::kShift, {.shift_m = {0.03, 0, 0.03}, .strip = 1}, {}, 1},
      {"drift 6 cm in height", K::kDrift, {.drift_m = {0, 0, 0.06}}},
      {"boresight 0.05 degrees", K::kBoresight, {.boresight_rad = {0.0009, 0, 0}}, turned},
      {"vertical datum 2.5 cm", K::kVerticalDatum, {.shift_m = {0, 0, 0.025}}},
      {"positions of the next image, sigma 10 m", K::kAssignment, {.assignment = 1}, coarse},
      {"bowl 6 cm", K::kBowl, {.bowl_m = 0.06}, free},
      {"b1 0.3 px", K::kAffinity, {.b1_px = 0.3}},
      {"rolling shutter 3 ms", K::kRollingShutter, {.shutter_s = 0.003}},
      {"refraction, 300 times", K::kRefraction, {.refraction = 300}},
      {"polynomial 0.25 px",
       K::kAdditional,
       {.additional = AdditionalSet::kPolynomial, .additional_px = 0.25},
       {},
       -1,
       AdditionalSet::kPolynomial},
      {"Fourier 0.15 px",
       K::kAdditional,
       {.additional = AdditionalSet::kFourier, .additional_px = 0.15},
       {},
       -1,
       AdditionalSet::kFourier}};
  print_detection(cases, blocks, run);
  print_false_alarms(blocks, run);
  FlightOptions few;
  few.strips = 3;
  const std::vector<Case> taken = {
      {"none", K::kTimeOffset, {}},
      {"time offset 37 ms", K::kTimeOffset, {.time_offset_s = 0.037}, few},
      {"lever arm 10, 0, 30 cm", K::kLeverArm, {.lever_arm_m = {0.1, 0, 0.3}}, few},
      {"shift 20, 10, 50 cm", K::kShift, {.shift_m = {0.2, 0.1, 0.5}}, few},
      {"shift of a strip 10, 0, 10 cm", K::kShift, {.shift_m = {0.1, 0, 0.1}, .strip = 1}, few}};
  print_check_points(taken, blocks, run);
}

}  // namespace collinea

int main(int argc, char** argv) {
  collinea::Run run;
  run.threads = argc > 2 ? std::atoi(argv[2]) : 2;
  collinea::print_systematics(argc > 1 ? std::atoi(argv[1]) : 200, run);
  return 0;
}
