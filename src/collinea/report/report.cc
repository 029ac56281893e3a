// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/report.h"

#include "collinea/base/file.h"
#include "collinea/base/sha256.h"
#include "collinea/report/internal/page.h"
#include "collinea/report/internal/report_json.h"

namespace collinea {
Result<> write_report(const ReportInput& input, const std::filesystem::path& folder) {
  ReportInput shown = input;
  const auto previews = [&](const std::filesystem::path& dsm, const std::filesystem::path& ortho) {
    return ProductPreviews{preview_or_finding(preview_of_heights, dsm, shown.findings),
                           preview_or_finding(preview_of_image, ortho, shown.findings)};
  };
  const ProductPreviews map = previews(input.dsm, input.ortho);
  std::vector<ProductPreviews> frames;
  for (const FrameRecord& frame : outcome_in<FramesRecord>(input.steps).frames)
    frames.push_back(previews(input.frames / frame.name / "dsm.tif", input.frames / frame.name / "ortho.tif"));
  const ReportSummary summary = summary_of(shown);
  const std::pair<const char*, std::string> files[] = {{"report.html", report_page(shown, summary, map, frames)},
                                                       {"report.json", report_json(shown, summary)}};
  for (const auto& [name, text] : files) COLLINEA_TRY(write_file(folder / name, text));
  if (!input.files) return {};
  SignedFiles all = *input.files;
  for (const auto& [name, text] : files)
    all.files.push_back({FileRole::kReport, std::string("report/") + name, {}, text.size(), Sha256().add(text).hex()});
  return write_file(folder / "hashes.json", signed_files_json(all));
}

}  // namespace collinea
