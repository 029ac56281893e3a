// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "collinea/quality/internal/rejection.h"

namespace collinea {

/// What a joint test of several gross errors says differently from one after the other.
struct MaskedChoice {
  Remaining before;      ///< with all that was given put back
  SuspectChoice choice;  ///< of that, what is to be rejected; empty where nothing can be told
  StayReasons stays;     ///< members of sets that cannot be told from each other
  std::vector<InseparableSets> inseparable;
  bool is_undecided = false;  ///< something wrong stays
  bool is_other = false;      ///< than what went; otherwise only `inseparable` says something new
};

/// Looks for gross errors that mask each other, or that made a good measurement look wrong, among what was given: after
/// data snooping has rejected some of it, or has left suspects. Model:
///
///  - all of it is put back, with the values that the others say, and adjusted together, which nothing bends;
///  - to the scores of that adjustment the gross errors are added, G g with the joint cofactors G (with_errors()): the
///    tests of an adjustment with all gross errors, and without any set of them (JointSystem), linear for any size;
///  - the smallest set that explains everything is chosen (explanations()). What went stays rejected if it explains as
///    much with as few (its statistic is less than 14 behind: a thousandth as probable);
///  - two sets that say the same (canonical correlations beyond 0.99) and explain as much cannot be told apart: they
///    are named. What they have in common goes; of a mark and the coordinates of its point, which say nothing of the
///    rest whichever goes, the more probable; all else stays, since what is wrong there spoils its tests. So does what
///    shows less than a five hundredth of its errors.
///
/// Nothing with more than 80 measurements that were given: each is then checked by many others, which two or three do
/// not outvote. Cost: one adjustment and a solution for each coordinate that was given; linear in the block.
[[nodiscard]] std::optional<MaskedChoice> masked_choice(const Remaining& remaining, const SuspectChoice& last,
                                                        const AdjustOptions& adjust, const Reliability& tests,
                                                        const Run& run);

}  // namespace collinea
