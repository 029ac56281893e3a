// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/systematics_taken_up.h"

#include <set>

#include "collinea/orient/instrument_options.h"
#include "collinea/quality/additional_choice.h"
#include "collinea/quality/systematic_findings.h"

namespace collinea {
namespace {

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

Result<bool> take_up_instrument(TakingUp& done) {
  const InstrumentOptions next = taken_up(done.adjusted.systematics, done.instruments);
  const InstrumentOptions more = added(done.instruments, next);
  if (!is_any(more)) return false;
  apply(done.adjusted, done.block);  // velocities come from it
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

// Cameras of which the adjustment was free to choose the parameters: calibrated as the options say, without others.
std::set<CameraId> cameras_to_extend(Calibration calibration, const TakingUp& done) {
  std::set<CameraId> cameras;
  if (calibration == Calibration::kNone) return cameras;
  for (const auto& [id, camera] : done.block.cameras)
    if (camera.prior.calibrate && camera.additional == AdditionalSet::kNone && !done.scope.fixed_cameras.contains(id) &&
        !done.scope.camera_sigmas.contains(id))
      cameras.insert(id);
  return cameras;
}

bool take_up_deformation(Calibration calibration, TakingUp& done) {
  const std::vector<SystematicTest>& tests = done.adjusted.systematics;
  const auto number = deformation_taken_up(tests, cameras_to_extend(calibration, done));
  if (!number) return false;
  const SystematicTest& test = tests[*number];
  apply(done.adjusted, done.block);
  Camera& camera = done.block.cameras.at(*test.camera);
  Camera& first = done.scope.first_cameras.try_emplace(*test.camera, camera).first->second;
  camera.additional = first.additional = test.additional;
  const Calibration its = test.kind == SystematicKind::kAffinity ? Calibration::kBrownAffinity : calibration;
  done.scope.camera_sigmas[*test.camera] = with_additional(calibration_sigmas(its, first), first, {}).value();
  done.taken_up.push_back(taken_up_finding(tests, test, done.block));
  return true;
}

}  // namespace

Result<bool> take_up_systematics(const AdjustmentOptions& asked, Calibration calibration, TakingUp done) {
  COLLINEA_TRY(const bool instrument, take_up_instrument(done));
  if (instrument) return true;
  if (asked.additional || asked.calibration) return false;  // what cameras have was chosen
  return take_up_deformation(calibration, done);
}

}  // namespace collinea
