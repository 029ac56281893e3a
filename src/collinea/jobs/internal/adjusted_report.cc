// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/adjusted_report.h"
#include "collinea/quality/gross_errors.h"
#include "collinea/report/diverged.h"
#include "collinea/report/finding_words.h"

#include <fmt/format.h>

#include <algorithm>

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

// Refuses what is no adjustment, and names what contradicts the others so much that tests say little.
Result<> judge(const Result<Examined>& adjusted, const Block& block, const AdjustScope& scope,
               const ExamineOptions& options, const Run& run) {
  if (!is_bent(adjusted, options.test)) return {};
  const GrossErrors gross = find_gross_errors(block, scope, options.adjust, adjusted ? &*adjusted : nullptr, run);
  if (!adjusted) {
    if (gross.measurements.empty()) return tl::unexpected(adjusted.error());
    return tl::unexpected(naming(adjusted.error(), gross, block));
  }
  if (auto error = diverged(*adjusted, gross, block)) return tl::unexpected(naming(std::move(*error), gross, block));
  for (std::size_t i = 0; i < std::min<std::size_t>(5, gross.measurements.size()); ++i)
    run.say("note: contradicts the others: " + words_of_rejected(gross.measurements[i], block));
  return {};
}

// Data snooping, and when it fails what does not fit.
Result<Snooped> snooped_block(const Block& block, const AdjustScope& scope, const ExamineOptions& options, int most,
                              const Run& run) {
  Result<Snooped> snooped = snoop(block, scope, options, most, run);
  if (snooped) return snooped;
  const Errc code = snooped.error().code;
  if (code != Errc::kIllPosed && code != Errc::kNotConverged) return snooped;
  const GrossErrors gross = find_gross_errors(block, scope, options.adjust, nullptr, run);
  if (gross.measurements.empty()) return snooped;
  return tl::unexpected(naming(std::move(snooped).error(), gross, block));
}

}  // namespace

Result<AdjustmentReport> adjusted_report(Block block, const AdjustScope& scope, const ExamineOptions& options,
                                         const AdjustProjectOptions& asked, const Run& run) {
  AdjustmentReport report;
  report.block = std::move(block);
  AdjustScope left = scope;
  if (asked.snoop) {
    COLLINEA_TRY(report.snooped, snooped_block(report.block, scope, options, asked.snoop_most, run));
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
    Adjuster adjuster;
    int adjustments = 0;
    Result<Examined> adjusted = examine_to_the_end(adjuster, report.block, scope, options, run, adjustments);
    COLLINEA_TRY(judge(adjusted, report.block, scope, options, run));
    report.adjusted = *std::move(adjusted);
  }
  if (asked.snoop || asked.variance_components) COLLINEA_TRY(judge(report.adjusted, report.block, left, options, run));
  report.additional_level = asked.additional_level;
  report.additional = test_additional(report.block, report.adjusted, options.test.sigma0_known, asked.additional_level);
  for (const Finding& weak : report.adjusted.weaknesses) run.say("note: " + sentence_of(weak, report.block));
  apply(report.adjusted, report.block);
  return report;
}

}  // namespace collinea
