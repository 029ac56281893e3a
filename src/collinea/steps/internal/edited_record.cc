// SPDX-License-Identifier: Apache-2.0
#include "collinea/steps/internal/edited_record.h"

#include <algorithm>

#include "collinea/import/unseen_control.h"

namespace collinea {
namespace {

Finding finding_of_edit(const UnfitEdit& edit) {
  return finding_of(FindingCode::kEditUnfit, {Subject::control_named(edit.point)},
                    {{FigureName::kLine, static_cast<double>(edit.number)}}, {},
                    edit.command + ": " + edit.why.message);
}

// Of an edit that was undone since nothing has to be said.
bool is_undone(const Finding& finding, const EditHistory& history) {
  if (finding.code != FindingCode::kEditUnfit) return false;
  const auto numbers = finding.figures_of(FigureName::kLine);
  const auto number = static_cast<std::uint64_t>(numbers.empty() ? 0 : numbers[0]);
  return number == 0 || number > history.number() || history.at(number).undone;
}

}  // namespace

Result<ImportRecord> with_edits(ImportRecord record, const ProjectStore& store, const std::vector<UnfitEdit>& unfit) {
  COLLINEA_TRY(const Block setup, store.read_setup());
  record.control_points = setup.control.size();
  record.findings = with_unseen_control(std::move(record.findings), setup);
  for (const UnfitEdit& edit : unfit) record.findings.push_back(finding_of_edit(edit));
  return record;
}

Result<> renew_import_record(Project& project, const EditHistory& history) {
  if (history.number() == 0) return {};
  COLLINEA_TRY(const ImportRecord before, project.store.read_outcome<ImportRecord>());
  ImportRecord record = before;
  std::erase_if(record.findings, [&](const Finding& finding) { return is_undone(finding, history); });
  COLLINEA_TRY(record, with_edits(std::move(record), project.store, {}));
  const bool is_same = record.control_points == before.control_points && record.findings == before.findings;
  return is_same ? Result<>{} : project.store.write_outcome(record);
}

}  // namespace collinea
