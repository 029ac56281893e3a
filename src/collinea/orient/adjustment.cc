// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/adjustment.h"

#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "collinea/orient/flight_strips.h"
#include "collinea/orient/instrument_options.h"
#include "collinea/quality/divergence.h"
#include "collinea/quality/systematic_findings.h"

namespace collinea {
namespace {

// "a3, a7" as its names.
std::vector<std::string> names_in(std::string_view list) {
  std::vector<std::string> names;
  std::string name;
  for (const char one : list) {
    if (one == ' ' || one == '\t') continue;
    if (one != ',') {
      name += one;
      continue;
    }
    if (!name.empty()) names.push_back(std::exchange(name, {}));
  }
  if (!name.empty()) names.push_back(std::move(name));
  return names;
}

Error no_such_parameter(const AdjustmentOptions& asked, AdditionalSet set) {
  const std::string last = "a" + std::to_string(count_of(set));
  return {Errc::kBadInput,
          "additional_fixed = \"" + asked.additional_fixed + "\": the " + std::to_string(count_of(set)) +
              " parameters of " + std::string(kAdditionalNames[std::size_t(set)]) + " are a1 to " + last,
          {"additional_fixed"_option}};
}

void change_set(Camera& camera, AdditionalSet set) {
  if (camera.additional != set) std::fill(camera.params.begin() + Camera::kParams, camera.params.end(), 0.0);
  camera.additional = set;
}

bool is_to_be_corrected(RefractionChoice choice, const Block& block) {
  constexpr double kNoticeable_px = 0.05;  // a tenth of what images of tie points are measured to
  if (choice != RefractionChoice::kAuto) return choice == RefractionChoice::kOn;
  return largest_refraction_px(block) > kNoticeable_px;
}

SystematicOptions systematics_of(const AdjustmentOptions& asked, const Adjustment& done) {
  SystematicOptions options;
  options.test = asked.systematics != Systematics::kNone;
  if (!options.test) return options;
  options.level = asked.systematics_level;
  options.sigma0_known = asked.tests.sigma0_known;
  options.refraction_corrected = done.refracted.has_value();
  for (const FlightStrip& strip : flight_strips(done.block)) options.strips.push_back(strip);
  options.velocity_m_s = flight_velocities(done.block);
  return options;
}

// What the next options have and these have not.
InstrumentOptions added(const InstrumentOptions& now, const InstrumentOptions& next) {
  InstrumentOptions more;
  if (next.time_offset && !now.time_offset) more.time_offset = true;
  if (has_lever_arm(next) && !has_lever_arm(now)) more.lever_arm = next.lever_arm;
  if (next.position_shift != now.position_shift) more.position_shift = next.position_shift;
  return more;
}

bool is_any(const InstrumentOptions& more) {
  return more.time_offset || has_lever_arm(more) || more.position_shift != PositionShift::kNone;
}

// The strongest error of an instrument that is beyond doubt takes part from now on. False: there is none.
Result<bool> take_up_instrument(Adjustment& done) {
  const InstrumentOptions next = taken_up(done.adjusted.systematics, done.instruments);
  const InstrumentOptions more = added(done.instruments, next);
  if (!is_any(more)) return false;
  COLLINEA_TRY(add_instruments(done.block, more, done.scope));
  const auto is_it = [&](const SystematicTest& test) {
    return (test.kind == SystematicKind::kTimeOffset && more.time_offset) ||
           (test.kind == SystematicKind::kLeverArm && has_lever_arm(more)) ||
           (test.kind == SystematicKind::kShift && more.position_shift != PositionShift::kNone);
  };
  const SystematicTest* strongest = nullptr;
  for (const SystematicTest& test : done.adjusted.systematics)
    if (is_it(test) && (!strongest || test.p_value < strongest->p_value)) strongest = &test;
  if (strongest) done.taken_up.push_back(taken_up_finding(done.adjusted.systematics, *strongest, done.block));
  done.instruments = next;
  return true;
}

// One adjustment, with gross errors rejected where they are to be.
Result<> adjust_once(const AdjustmentTask& task, const ExamineOptions& options, const AdjustmentOptions& asked,
                     const Run& run, Adjustment& done) {
  if (task.snoop) {
    COLLINEA_TRY(done.snooped, snoop(done.block, done.scope, options, asked.snoop_most, run, *task.snoop));
    done.block = done.snooped->block;
    done.scope.attitudes = done.snooped->attitudes;
    done.adjusted = std::move(done.snooped->adjusted);
    return {};
  }
  COLLINEA_TRY(done.adjusted, examine_strictly(done.block, done.scope, options, run));
  return {};
}

}  // namespace

Result<std::vector<std::string>> set_additional(const AdjustmentOptions& asked, AdjustmentTask& task) {
  const std::vector<std::string> fixed = names_in(asked.additional_fixed);
  std::set<std::string> instead;
  bool any = false;
  for (auto& [id, camera] : task.block.cameras) {
    const auto own = task.scope.camera_sigmas.find(id);
    Camera& first = task.scope.first_cameras.try_emplace(id, camera).first->second;
    if (asked.additional) {
      change_set(camera, *asked.additional);
      change_set(first, *asked.additional);
    } else {
      first.additional = camera.additional;  // found by orient, around zero
    }
    if (camera.additional == AdditionalSet::kNone) continue;
    any = true;
    if (own != task.scope.camera_sigmas.end() && !asked.additional && fixed.empty()) continue;
    CameraSigmas sigmas{};  // a camera that was given stays as it is beneath them
    if (own != task.scope.camera_sigmas.end())
      sigmas = own->second;
    else if (camera.prior.calibrate)
      sigmas = calibration_sigmas(task.options.adjust.calibration, first);
    const auto both = with_additional(sigmas, first, fixed);
    if (!both) return tl::unexpected(no_such_parameter(asked, camera.additional));
    for (int k = 0; k < Camera::kParams; ++k)
      if (sigmas[std::size_t(k)] > 0 && (*both)[std::size_t(k)] == 0) instead.insert(param_name(k));
    task.scope.camera_sigmas[id] = *both;
  }
  if (!fixed.empty() && !any)
    return fail(Errc::kBadInput, "additional parameters are to be fixed, but no camera has any",
                {"additional_fixed"_option, "additional"_option});
  return std::vector<std::string>(instead.begin(), instead.end());
}

Result<Adjustment> adjust_block(AdjustmentTask task, const AdjustmentOptions& asked, const Run& run) {
  constexpr int kMostTakenUp = 4;
  Adjustment done;
  if (is_to_be_corrected(asked.refraction, task.block)) {
    COLLINEA_TRY(done.refracted, correct_refraction(task.block));
  }
  done.scope = with_first_cameras(task.scope, task.block.cameras);
  done.instruments = task.instruments;
  done.block = std::move(task.block);
  if (task.reject_mismatches) {
    COLLINEA_TRY(WithoutMismatches clean, reject_mismatches(std::move(done.block), done.scope, task.options.adjust,
                                                            task.options.test.false_alarm, run));
    done.block = std::move(clean.block);
    done.mismatches = std::move(clean.found);
  }
  ExamineOptions options = task.options;
  options.systematics = systematics_of(asked, done);
  COLLINEA_TRY(adjust_once(task, options, asked, run, done));
  for (int taken = 0; taken < kMostTakenUp && asked.systematics == Systematics::kAuto; ++taken) {
    COLLINEA_TRY(const bool more, take_up_instrument(done));
    if (!more) break;
    apply(done.adjusted, done.block);
    COLLINEA_TRY(adjust_once(task, options, asked, run, done));
  }
  if (asked.variance_components) {
    COLLINEA_TRY(done.components, estimate_variance_components(done.block, done.scope, options, run));
    done.adjusted = done.components->adjusted;
    COLLINEA_TRY(refuse_diverged(done.adjusted, done.block, done.scope, options, run));
    done.block = with_sigmas(done.block, done.components->factors);
  }
  done.additional_level = asked.additional_level;
  done.additional = test_additional(done.block, done.adjusted, options.test.sigma0_known, asked.additional_level);
  apply(done.adjusted, done.block);
  return done;
}

}  // namespace collinea
