// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "collinea/quality/examine.h"
#include "collinea/quality/internal/rejected.h"

namespace collinea {

/// What data snooping may reject: everything, or what is given (control in images and on the ground, positions,
/// attitudes, measurements on the ground), but no tie points: of thousands a few go by chance, and mismatches are found
/// all at once (reject_mismatches()).
enum class SnoopedKinds : std::uint8_t { kAll, kGiven };

/// What data snooping leaves.
struct Snooped {
  Block block;                                 ///< without what was rejected; geodetic observations are only compared
  std::map<ImageId, GivenAttitude> attitudes;  ///< of the scope, those that were rejected with infinite sigmas
  std::vector<Rejected> rejected;              ///< in the order in which it went
  std::vector<KeptSuspect> kept;               ///< suspects of the last adjustment that cannot go, worst first
  std::vector<InseparableSets> inseparable;    ///< of suspects that stay: which of two sets is wrong cannot be told
  int put_back = 0;                            ///< that went, and in the end agreed with what was left
  int rounds = 0;                              ///< adjustments
  bool finished = false;                       ///< nothing is left that could be rejected
  double sigma0_before = 0;                    ///< with everything; of a bent one, if it has tests
  std::vector<ControlDifference> with;         ///< control and check points, with everything
  Examined adjusted;                           ///< the last, with reliability
};

/// Data snooping (Baarda 1968; Kok 1984): adjusts, rejects the worst suspect, adjusts again, until no suspect is left
/// or `most` have been rejected.
///
/// Model: at most a few observations have a gross error g, a shift of their mean. Each is tested against what the
/// others predict, w = g / sigma_g with g = v / r, residual over redundancy number (see reliability_of()). One gross
/// error shows in the residuals of all observations it is correlated with, so that only the worst is believed; a round
/// of the loop is
///
///     adjust, by least squares; test all observations
///     when something is not determined any more, or the rejected is not to be told from another: take the round back
///     choose the suspects that go, worst first (choose_suspects())
///     reject them
///
/// In the end what agrees with what is left is put back, once (agreeing()): another gross error had spoilt it. Where
/// two or more of what was given have gone, or suspects stay, all of it is looked at together: pairs and triples that
/// mask each other, or that made a good one look wrong, go in its place (masked_choice()).
///
/// What cannot be decided stays, with its reason (StayReason). Foerstner's limits of controllability hold: below a
/// redundancy of 0.01 nothing shows a gross error, below 0.1 little does. Of two observations whose tests have a
/// correlation near 1 neither goes, since which of them is wrong cannot be told (Foerstner 1983; doubts()). When
/// without a round something is not determined or the datum has a larger defect, half of it is tried, until the one
/// that must stay is found.
///
/// Image points of control that are grossly wrong go before the first adjustment, which they would bend
/// (without_gross_control()). Where the first adjustment is bent all the same (is_bent()), linear tests say nothing of
/// it: gross errors are found by a robust fit and go first where that can be told (choose_gross()). Where it cannot,
/// they stay, with those others that may be wrong instead, and nothing else is rejected.
///
/// Example:
///
///     COLLINEA_TRY(const Snooped snooped, snoop(block, scope, {.adjust = {.loss = Loss::kNone}}, 1000, run));
///     for (const Rejected& gone : snooped.rejected) ...  // gone.gross_error[gone.axis], gone.sigma
///
/// Cost: one adjustment with its selected inverse for each round; many gross errors in image points go in one round,
/// each of another kind needs its own. Without a robust loss gross errors are found as theory says; with one they are
/// tested by their full sigmas all the same.
///
/// Errors: those of adjust(); kIllPosed when something is not determined with all observations; kNotConverged when what
/// contradicts the others cannot be told from them and drives the adjustment away (refuse_diverged()).
[[nodiscard]] Result<Snooped> snoop(const Block& block, const AdjustScope& scope, const ExamineOptions& options,
                                    int most, const Run& run, SnoopedKinds kinds = SnoopedKinds::kAll);

/// What was rejected of that which was given (no tie points), a finding each: by how much it is off, the standard
/// deviation of that, and how far it had moved its adjusted value [px, m, deg].
[[nodiscard]] std::vector<Finding> rejected_findings(const Snooped& snooped);

}  // namespace collinea
