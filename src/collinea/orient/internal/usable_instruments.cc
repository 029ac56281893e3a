// SPDX-License-Identifier: Apache-2.0
#include "collinea/orient/internal/usable_instruments.h"

#include <algorithm>
#include <map>

#include "collinea/orient/instrument_options.h"

namespace collinea {
namespace {

// Whether a surveyed point that takes part is seen twice.
bool has_control(const Block& setup, const AdjustScope& scope) {
  std::map<ControlId, int> seen;
  for (const ControlObservation& one : setup.control_observations) ++seen[one.point];
  return scope.use_control && std::any_of(seen.begin(), seen.end(), [&](const auto& point) {
           const ControlPoint& control = setup.control.at(point.first);
           return point.second > 1 && control.role == ControlRole::kControl && control.sigma_m.allFinite();
         });
}

}  // namespace

UsableInstruments usable_instruments(const InstrumentOptions& asked, const Block& setup, const AdjustScope& scope,
                                     bool georeferenced) {
  UsableInstruments usable{asked, {}};
  InstrumentOptions& options = usable.options;
  if (!georeferenced || !scope.use_positions) {
    options.lever_arm.reset();
    options.position_shift = PositionShift::kNone;
    options.position_drift = options.time_offset = false;
    if (is_of_positions(asked)) usable.findings.push_back(finding_of(FindingCode::kPositionsUnused));
  }
  if (!georeferenced && options.use_attitudes) {
    options.use_attitudes = false;
    usable.findings.push_back(finding_of(FindingCode::kAttitudesUnused));
  }
  if (options.position_shift != PositionShift::kNone && !has_control(setup, scope)) {
    options.position_shift = PositionShift::kNone;
    options.position_drift = false;
    usable.findings.push_back(finding_of(FindingCode::kShiftUnused));
  }
  return usable;
}

}  // namespace collinea
