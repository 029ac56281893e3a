// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/rejected.h"
#include "collinea/quality/internal/rivals.h"

namespace collinea {

/// How many measurements may go.
struct ChoiceBounds {
  std::size_t of_round = 0;  ///< in this round
  int in_all = 0;            ///< before the bound that was asked for is reached
};

/// A suspect that is to be rejected.
struct ChosenSuspect {
  TestedObservation test;  ///< of its worst coordinate
  Measurement measurement;
  bool as_pair = false;  ///< the only other ray of its point goes with it
};

/// What a round rejects, by the tests of an adjustment.
struct SuspectChoice {
  std::vector<ChosenSuspect> suspects;      ///< worst first
  std::vector<MeasurementIndex> last_rays;  ///< of points of which a single ray would be left: they go too
  std::vector<KeptSuspect> kept;            ///< suspects that stay, worst first
  std::optional<Rivals> rivals;             ///< of the one of `suspects` that is no image point
  bool bound_is_reached = false;            ///< more is suspect than may go in all
};

/// Chooses the suspects of an adjustment that go in one round: one pass over Reliability::suspects, worst first by
/// TestedObservation::suspicion, which (unlike |w|) is largest for the wrong one if there is but one (Baarda 1968).
///
/// Only those go together that cannot disturb each other:
///  - of each tie point or control point one image point;
///  - of each image those image points that would be suspect whatever the worse ones in it did to them: a gross error
///    in one of n rays of an image shows in another as h / r of itself, where h, of the six unknowns of the image, is
///    3 / n on average and three times that in corners: it may explain 10 / n of its w;
///  - of coordinates, geodetic observations and attitudes the worst alone, unless an image point of their control
///  points
///    is worse, and after it no image point.
///
/// A suspect stays
///  - by `stays`, where an earlier round has shown so;
///  - when too little of a gross error shows in its residual: redundancy below 0.01 (not controllable, Foerstner);
///  below
///    0.1 for image points, and after a worse one that is no image point and stays, which may have spoilt it;
///  - an image point when its image would keep fewer than six, or when a worse coordinate of its control point stays.
/// Image points that their image does not see always go.
///
/// `block`: that was tested.
[[nodiscard]] SuspectChoice choose_suspects(const Examined& adjusted, const Block& block, const StayReasons& stays,
                                            const ChoiceBounds& bounds);

}  // namespace collinea
