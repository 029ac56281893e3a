// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "collinea/adjust/bundle.h"
#include "collinea/base/options.h"
#include "collinea/quality/control_check.h"

namespace collinea {

/// What positions have in common that only control tells.
enum class PositionShift { kNone, kBlock, kStrips };
inline constexpr Word<PositionShift> kPositionShiftWords[] = {{PositionShift::kNone, "none"},
                                                              {PositionShift::kBlock, "block", "one of all"},
                                                              {PositionShift::kStrips, "strips", "one of each strip"}};
[[nodiscard]] constexpr std::span<const Word<PositionShift>> words(PositionShift) { return kPositionShiftWords; }

/// What receivers and inertial systems measure, and what of their mounting is to be found.
struct InstrumentOptions {
  std::optional<std::string> lever_arm;
  PositionShift position_shift = PositionShift::kNone;
  bool position_drift = false;
  bool time_offset = false;
  bool use_attitudes = false;
  double attitude_sigma_deg = 1;
  double heading_sigma_deg = 3;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = InstrumentOptions;
    visit(Field{"lever_arm", &O::lever_arm, "m",
                "antenna from the projection centre in the camera, right,down,forward: x,y,z; or estimate, or none"});
    visit(Field{"position_shift", &O::position_shift, "",
                "shift that the positions have in common, to be found with control"});
    visit(Field{"position_drift", &O::position_drift, "", "and a drift in time"});
    visit(Field{"time_offset", &O::time_offset, "",
                "find by how much later than the pictures their positions were taken, for each camera"});
    visit(Field{"use_attitudes", &O::use_attitudes, "",
                "use the attitudes that the cameras wrote, with a boresight to be found for each camera"});
    visit(Field{"attitude_sigma_deg", &O::attitude_sigma_deg, "deg",
                "standard deviation of attitudes from level, where none is stated", 1e-6, 90});
    visit(Field{"heading_sigma_deg", &O::heading_sigma_deg, "deg", "the same of their heading", 1e-6, 180});
  }
};

/// A lever arm is given, or to be found.
[[nodiscard]] bool has_lever_arm(const InstrumentOptions& asked);
/// Something of the positions is to be found or taken into account.
[[nodiscard]] bool is_of_positions(const InstrumentOptions& asked);

/// Whether the words are among those there are, and the block has what they are about: positions, times, attitudes.
[[nodiscard]] Result<> check_instruments(const InstrumentOptions& asked);
[[nodiscard]] Result<> check_instruments(const InstrumentOptions& asked, const Block& block);

/// Puts it into the scope of an adjustment of an oriented block: strips and velocities come from its centres. Errors as
/// check_instruments().
[[nodiscard]] Result<> add_instruments(const Block& block, const InstrumentOptions& asked, AdjustScope& scope);

/// Where their shift is to be found, positions that lie off the control by a constant are what was expected, unless by
/// so much that they belong to another coordinate system.
void expect_shift(ControlDiagnosis& diagnosis);

}  // namespace collinea
