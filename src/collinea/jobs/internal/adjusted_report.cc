// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/adjusted_report.h"
#include "collinea/report/finding_words.h"

#include <fmt/format.h>

namespace collinea {
namespace {

void report_rejected(const Snooped& snooped, const Run& run) {
  constexpr std::size_t kShown = 5;
  for (std::size_t i = 0; i < std::min(kShown, snooped.rejected.size()); ++i)
    run.say("note: rejected: " + words_of_rejected(snooped.rejected[i], snooped.block));
  if (snooped.rejected.size() > kShown)
    run.say(fmt::format("note: {} observations rejected in all; rejected.csv lists them", snooped.rejected.size()));
  for (std::size_t i = 0; i < std::min(kShown, snooped.kept.size()); ++i)
    run.say(fmt::format("note: {} is suspect but stays: {}", name_of(snooped.kept[i].observation, snooped.block),
                        words_of(snooped.kept[i].reason)));
  if (!snooped.finished) run.say("note: more is suspect; as many as were allowed have gone (snoop_most)");
}

void report_mismatches(const Mismatches& found, const Run& run) {
  if (found.size() == 0) return;
  run.say(fmt::format("note: {} of {} measurements of tie points are mismatches and rejected, {} others with them",
                      found.wrong.size(), found.tested, found.with_them.size()));
}

}  // namespace

Result<AdjustmentReport> adjusted_report(Block block, const AdjustScope& scope, const ExamineOptions& options,
                                         const AdjustProjectOptions& asked, const Run& run) {
  AdjustmentReport report;
  report.block = std::move(block);
  if (asked.reject_mismatches.value_or(false)) {
    COLLINEA_TRY(WithoutMismatches clean,
                 reject_mismatches(std::move(report.block), scope, options.adjust, options.test.false_alarm, run));
    report.block = std::move(clean.block);
    report.mismatches = std::move(clean.found);
    report_mismatches(*report.mismatches, run);
  }
  AdjustScope left = scope;
  if (asked.snoop) {
    COLLINEA_TRY(report.snooped, snoop(report.block, scope, options, asked.snoop_most, run));
    report_rejected(*report.snooped, run);
    report.block = report.snooped->block;
    left.attitudes = report.snooped->attitudes;
  }
  if (asked.variance_components) {
    COLLINEA_TRY(report.components, estimate_variance_components(report.block, left, options, run));
    if (!report.components->converged)
      run.say("note: the variance components have not settled; the last ones are used");
    report.adjusted = report.components->adjusted;
    report.block = with_sigmas(report.block, report.components->factors);
  } else if (asked.snoop) {
    report.adjusted = std::move(report.snooped->adjusted);
  } else {
    COLLINEA_TRY(report.adjusted, examine(report.block, scope, options, run));
  }
  report.additional_level = asked.additional_level;
  report.additional = test_additional(report.block, report.adjusted, options.test.sigma0_known, asked.additional_level);
  for (const Finding& weak : report.adjusted.weaknesses) run.say("note: " + sentence_of(weak, report.block));
  apply(report.adjusted, report.block);
  return report;
}

}  // namespace collinea
