// SPDX-License-Identifier: Apache-2.0
#include "collinea/report/report.h"

#include "collinea/base/file.h"
#include "collinea/base/sha256.h"
#include "collinea/report/internal/page.h"
#include "collinea/report/internal/report_json.h"

namespace collinea {
namespace {

constexpr int kPreviewSide_px = 900;

using MakePreview = Result<Preview> (*)(const std::filesystem::path&, int);

// A preview is a help, not a figure: when it cannot be made the report says so and goes on.
std::optional<Preview> preview(MakePreview make, const std::filesystem::path& file, std::vector<Finding>& findings) {
  if (file.empty()) return std::nullopt;
  Result<Preview> made = make(file, kPreviewSide_px);
  if (made) return *std::move(made);
  findings.push_back(
      finding_of(FindingCode::kNoPreview, {Subject::file(file.filename().string())}, {}, {}, made.error().message));
  return std::nullopt;
}

}  // namespace

Result<> write_report(const ReportInput& input, const std::filesystem::path& folder) {
  ReportInput shown = input;
  const auto heights = preview(preview_of_heights, input.dsm, shown.findings);
  const auto image = preview(preview_of_image, input.ortho, shown.findings);
  const ReportSummary summary = summary_of(shown);
  const std::pair<const char*, std::string> files[] = {{"report.html", report_page(shown, summary, heights, image)},
                                                       {"report.json", report_json(shown, summary)}};
  for (const auto& [name, text] : files) COLLINEA_TRY(write_file(folder / name, text));
  if (!input.files) return {};
  SignedFiles all = *input.files;
  for (const auto& [name, text] : files)
    all.files.push_back({FileRole::kReport, std::string("report/") + name, {}, text.size(), Sha256().add(text).hex()});
  return write_file(folder / "hashes.json", signed_files_json(all));
}

}  // namespace collinea
