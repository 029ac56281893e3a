// SPDX-License-Identifier: Apache-2.0
#include "collinea/adjust/gather.h"

#include <utility>

#include "collinea/adjust/internal/candidates.h"
#include "collinea/adjust/internal/datum_defect.h"
#include "collinea/adjust/internal/layout.h"
#include "collinea/adjust/internal/participants.h"

namespace collinea::bundle {

Result<ProblemAndStart> gather(const Block& block, const AdjustScope& scope, const AdjustOptions& options) {
  CandidateImages images = candidate_images(block, scope);
  COLLINEA_TRY(CandidatePoints points, candidate_points(block, scope, images));
  Participants participants = reject_weak(block, std::move(images), std::move(points));
  COLLINEA_TRY(check_there_is_something(participants, scope, options));
  const ImageOrder order = order_images(block, participants);
  COLLINEA_TRY(ProblemAndStart gathered, lay_out(block, scope, options, std::move(participants), order));
  gathered.problem.tie_loss = {options.loss, options.loss_scale_sigmas, 1};
  gathered.problem.position_loss = {
      options.position_loss,
      options.position_loss_scale_sigmas.value_or(AdjustOptions::kPositionLossScale * options.loss_scale_sigmas), 1};
  find_datum(gathered.problem, gathered.start);
  return gathered;
}

}  // namespace collinea::bundle
