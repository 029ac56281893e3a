// SPDX-License-Identifier: Apache-2.0
#include <array>

#include "collinea/base/parallel.h"
#include "collinea/project/adjustment_task.h"
#include "collinea/report/finding_words.h"
#include "collinea/report/write_adjustment.h"
#include "collinea/steps/internal/adjustment_record.h"
#include "collinea/steps/step.h"

namespace collinea {

Result<StepOutput> adjust_step(Project& project, const std::string& inputs_hash) {
  const AdjustmentOptions& options = project.settings.adjust;
  COLLINEA_TRY(ProjectAdjustment begun, adjustment_of(project, options));
  const Calibration calibration = begun.task.options.adjust.calibration;
  COLLINEA_TRY(const Block setup, project.store.read_setup());
  AdjustmentReport report;
  COLLINEA_TRY(static_cast<Adjustment&>(report), adjust_block(std::move(begun.task), options, project.run));
  report.title = title_of(project);
  report.spelling = project.run.spelling;
  const AdjustmentRecord record = record_of(report, begun.orientation, setup, calibration);
  std::array<Result<>, 2> written;
  parallel_for(project.run, written.size(), [&](std::size_t i) {
    written[i] = i == 0 ? write_adjustment(report, project.folder / "adjustment", project.run)
                        : project.store.write_adjustment(report.block, covariances_of(report));
  });
  for (Result<>& one : written) COLLINEA_TRY(std::move(one));
  for (const std::string& note : notes_of(report)) project.run.say("note: " + note);
  for (const Finding& finding : record.findings)
    project.run.say("note: " + sentence_of(finding, report.block, report.spelling));
  return StepOutput{inputs_hash, record};
}

}  // namespace collinea
