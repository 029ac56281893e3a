// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <utility>

#include "collinea/quality/internal/rejected.h"

namespace collinea {

/// Observations that may be wrong instead of the one that is rejected. Two tests of correlation rho cannot be told
/// apart when rho is near 1 (Foerstner 1983): a gross error in the one gives the other the share rho of its w. What is
/// not known before the one is rejected is rho; it shows afterwards, since the redundancy number of the other falls
/// with it from r to r (1 - rho^2).
struct Rivals {
  struct Rival {
    double redundancy = 0;  ///< before
    double behind = 0;      ///< suspicion of the worst minus its own
  };
  Measurement worst;                                    ///< which is rejected
  bool worst_is_poor = false;                           ///< little checks it (redundancy below kPoorRedundancy)
  std::map<std::pair<Measurement, int>, Rival> rivals;  ///< by the axis that is suspect
};

/// Foerstner: an observation of less redundancy is badly controllable, below a tenth of it not at all.
inline constexpr double kPoorRedundancy = 0.1;

/// The rivals of the worst suspect: those as suspect as itself to 1 %; where little checks it, those that are less
/// suspect by less than the limit of the difference of two uncorrelated tests, sqrt(2) times that of one. Image points
/// are no rivals. `block`: that was tested.
[[nodiscard]] Rivals rivals_of(const TestedObservation& worst, const Reliability& tests, const Block& block);

/// Why the worst should have stayed, by the tests without it. Empty: it was rightly rejected.
///
/// Of two observations that say the same of themselves none is left to check the other when one goes, so that both
/// stay: rho > 0.99. Where little checks the worst, it alone stays, also when a rival may be the wrong one instead: one
/// that is not suspect any more and was behind by less than limit sqrt(2 (1 - rho)), since the difference of two tests
/// has the variance 2 (1 - rho).
///
/// `block`: that was tested, without the worst.
[[nodiscard]] StayReasons doubts(const Rivals& rivals, const Reliability& tests_without, const Block& block);

}  // namespace collinea
