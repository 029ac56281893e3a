// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/examine.h"

#include <utility>

#include "collinea/quality/internal/control_folds.h"
#include "collinea/quality/internal/control_prediction.h"
#include "collinea/quality/internal/image_order.h"
#include "collinea/quality/internal/inseparable.h"
#include "collinea/quality/internal/score_tests.h"

namespace collinea {
namespace {

using bundle::ControlFolds;
using bundle::FreeNetwork;
using bundle::TileCholesky;
using bundle::WeaknessFinder;

/// The steps of examine(), which stops between them.
class Examination {
 public:
  Examination(Solved& solved, const ExamineOptions& options, const Run& run, Examined& out)
      : solved_(solved), options_(options), run_(run), out_(out), weaknesses_(solved, out) {}

  [[nodiscard]] Result<> examine() {
    weaknesses_.look_at_observations();
    auto [factor, failed_row] = solved_.factor(run_);
    if (run_.stopped()) return {};
    if (factor) {
      COLLINEA_TRY(examine_determined(*factor));
    } else {
      examine_undetermined(failed_row);
    }
    out_.weaknesses = weaknesses_.take();
    return {};
  }

 private:
  void examine_undetermined(int failed_row) {
    out_.undetermined = undetermined_unknown(solved_, failed_row);
    weaknesses_.look_at_bases(nullptr, run_);
    weaknesses_.look_at_loose_images(solved_, run_);
  }

  [[nodiscard]] Result<> examine_determined(TileCholesky& factor) {
    out_.conditioning = conditioning_of(solved_, factor, run_);
    weaknesses_.look_at_correlations(factor);
    const FreeNetwork free_network(solved_, factor, options_.datum, run_);
    if (!options_.datum.empty() && !free_network.has_datum_of_points())
      return fail(
          Errc::kIllPosed,
          "the points chosen for the datum do not tell position, attitude and scale of what nothing fixes: three "
          "off a line do, in each part of the block");
    bundle::predict_check_points(solved_, factor, free_network, run_, out_);
    std::optional<ControlFolds> folds;
    if (options_.reliability) folds.emplace(solved_, factor, run_);
    std::optional<bundle::ScoreTests> scores;
    if (options_.systematics.test) scores.emplace(solved_, options_.systematics, factor, run_);
    if (run_.stopped()) return {};
    factor.invert(run_);
    if (run_.stopped()) return {};
    take_covariances(free_network, factor);
    if (options_.reliability) test_observations(*folds, factor);
    if (scores && !run_.stopped()) out_.systematics = scores->tests(out_, factor, run_);
    if (options_.point_covariances && !run_.stopped())
      out_.point_covariance = point_covariances(solved_, out_.points, free_network, factor, run_);
    return {};
  }

  void take_covariances(const FreeNetwork& free_network, TileCholesky& inverse) {
    bundle::predict_control_points(solved_, inverse, free_network, out_);
    predict_others(solved_, free_network, inverse, out_);
    out_.inseparable = inseparable_unknowns(solved_, inverse);
    out_.pose_covariance = pose_covariances(solved_, free_network, inverse);
    weaknesses_.look_at_bases(&inverse, run_);
    weaknesses_.look_at_images(out_.pose_covariance);
    out_.camera_covariance = camera_covariances(solved_, inverse);
    out_.point_precisions = point_precisions(solved_, free_network, inverse, run_);
    out_.camera_pose_correlations = correlate_cameras_and_poses(solved_, out_.pose_covariance, free_network, inverse);
  }

  void test_observations(const ControlFolds& folds, TileCholesky& inverse) {
    Reliability found = reliability_of(solved_, out_, options_.test, inverse, run_);
    if (run_.stopped()) return;
    found.folded = folds.leave_out(solved_, out_, options_.test.folds);
    out_.reliability = std::move(found);
    out_.whitened_positions =
        bundle::whitened_positions(solved_, order_flown(solved_.block(), options_.systematics.strips), inverse);
  }

  Solved& solved_;
  const ExamineOptions& options_;
  const Run& run_;
  Examined& out_;
  WeaknessFinder weaknesses_;
};

}  // namespace

Result<Examined> examine(Solved solved, const ExamineOptions& options, const Run& run) {
  if (Result<> valid = validate(options.test); !valid)
    return tl::unexpected(std::move(valid).error().within("adjustment"));
  Examined examined{solved.take_estimate()};
  COLLINEA_TRY(Examination(solved, options, run, examined).examine());
  if (run.stopped()) return fail(Errc::kCancelled, "bundle adjustment stopped");
  return examined;
}

Result<Examined> examine(const Block& block, const AdjustScope& scope, const ExamineOptions& options, const Run& run) {
  Adjuster adjuster;
  return examine(adjuster, block, scope, options, run);
}

Result<Examined> examine(Adjuster& adjuster, const Block& block, const AdjustScope& scope,
                         const ExamineOptions& options, const Run& run) {
  if (Result<> valid = validate(options.test); !valid)
    return tl::unexpected(std::move(valid).error().within("adjustment"));
  AdjustOptions adjust = options.adjust;
  adjust.settle_points |= options.reliability;
  COLLINEA_TRY(Solved solved, adjuster.solve(block, scope, adjust, run));
  return examine(std::move(solved), options, run);
}

Result<Adjusted> adjust_with_control_precision(Adjuster& adjuster, const Block& block, const AdjustScope& scope,
                                               const AdjustOptions& options, const Run& run) {
  COLLINEA_TRY(Solved solved, adjuster.solve(block, scope, options, run));
  Adjusted adjusted = solved.take_estimate();
  auto [factor, failed_row] = solved.factor(run);
  if (factor && !run.stopped()) {
    const FreeNetwork free_network(solved, *factor);
    bundle::predict_check_points(solved, *factor, free_network, run, adjusted);
    factor->invert(run);
    if (!run.stopped()) bundle::predict_control_points(solved, *factor, free_network, adjusted);
  }
  if (run.stopped()) return fail(Errc::kCancelled, "bundle adjustment stopped");
  return adjusted;
}

Result<Examined> examine_to_the_end(Adjuster& adjuster, Block& block, const AdjustScope& scope,
                                    const ExamineOptions& options, const Run& run, int& adjustments) {
  constexpr int kMostRepeats = 3;
  const AdjustScope as_given = with_first_cameras(scope, block.cameras);
  for (int repeat = 0;; ++repeat) {
    Result<Examined> adjusted = examine(adjuster, block, as_given, options, run);
    ++adjustments;
    if (!adjusted || adjusted->converged || repeat == kMostRepeats) return adjusted;
    apply(*adjusted, block);
  }
}

}  // namespace collinea
