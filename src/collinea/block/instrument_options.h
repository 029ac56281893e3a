// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "collinea/base/options.h"

namespace collinea {

/// What positions have in common that only control tells.
enum class PositionShift { kNone, kBlock, kStrips };
inline constexpr Word<PositionShift> kPositionShiftWords[] = {{PositionShift::kNone, "none"},
                                                              {PositionShift::kBlock, "block", "one of all"},
                                                              {PositionShift::kStrips, "strips", "one of each strip"}};
[[nodiscard]] constexpr std::span<const Word<PositionShift>> words(PositionShift) { return kPositionShiftWords; }

/// What there may be in place of the three coordinates of a lever arm.
enum class LeverArmWord { kNone, kEstimate };
inline constexpr Word<LeverArmWord> kLeverArmWords[] = {{LeverArmWord::kNone, "none"},
                                                        {LeverArmWord::kEstimate, "estimate"}};
[[nodiscard]] constexpr std::span<const Word<LeverArmWord>> words(LeverArmWord) { return kLeverArmWords; }

/// The antenna from the projection centre, in the camera: right, down, forward [m]. A text is one for each camera, of
/// parts "NAME:x,y,z" (or estimate, or none) between semicolons; a part without a name is for cameras that no other
/// names, and without such a part these have none. Other texts are refused by check_instruments(), but for an empty
/// one, which is none.
using LeverArmOption = WordOr<LeverArmWord, ThreeNumbers, std::string>;

/// Describes options of instruments: those below, or what another struct of the same names changes of them. There
/// `unchanged` is the word for a shift that is not chosen, and what holds then.
template <class Owner, class Visit>
void describe_instruments(Visit&& visit, const Choice& unchanged = {}) {
  using O = Owner;
  visit(Field{"lever_arm", &O::lever_arm, "m",
              "antenna from the projection centre in the camera, right,down,forward: x,y,z; or estimate, or none; or "
              "one for each camera: NAME:x,y,z; NAME:estimate"});
  const auto shift = Field{"position_shift", &O::position_shift, "",
                           "shift that the positions have in common, to be found with control"};
  visit(unchanged.word.empty() ? shift : shift.or_auto(unchanged.meaning));
  visit(Field{"position_drift", &O::position_drift, "", "and a drift in time"});
  visit(Field{"time_offset", &O::time_offset, "",
              "find by how much later than the images their positions were taken, for each camera"});
  visit(Field{"use_attitudes", &O::use_attitudes, "",
              "use the attitudes that the cameras wrote, with a boresight to be found for each camera"});
  visit(Field{"attitude_sigma_deg", &O::attitude_sigma_deg, "deg",
              "standard deviation of attitudes from level, where none is stated", 1e-6, 90});
  visit(Field{"heading_sigma_deg", &O::heading_sigma_deg, "deg", "the same of their heading", 1e-6, 180});
}

/// What receivers and inertial systems measure, and what of their mounting is to be found.
struct InstrumentOptions {
  std::optional<LeverArmOption> lever_arm;
  PositionShift position_shift = PositionShift::kNone;
  bool position_drift = false;
  bool time_offset = false;
  bool use_attitudes = false;
  double attitude_sigma_deg = 1;
  double heading_sigma_deg = 3;

  template <class Visit>
  static void describe(Visit&& visit) {
    describe_instruments<InstrumentOptions>(visit);
  }
};

}  // namespace collinea
