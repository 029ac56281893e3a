// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/scan_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/feature/fiducial_search.h"
#include "collinea/io/number_rows.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// A template from the position that was pointed to; nothing without one.
Result<std::optional<MarkModel>> learnt(const GreyImage& scan, double mark_px, const ScanMarkOptions& options) {
  if (!options.mark_at) return std::optional<MarkModel>();
  const auto at = parse_numbers(*options.mark_at);
  if (!at || at->size() != 2)
    return fail(Errc::kBadInput, "the position of the mark is not two numbers with a comma between",
                {"mark_at"_option});
  auto model = learnt_mark(scan, {(*at)[0], (*at)[1]}, mark_px);
  if (!model)
    return fail(Errc::kBadInput, "nothing that could be a mark lies there in the first scan", {"mark_at"_option});
  return model;
}

}  // namespace

bool is_scan(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) || is_image_name(path);
}

Result<std::vector<ScanMarks>> find_scan_marks(const fs::path& path, const FilmCalibration& calibration,
                                               std::optional<double> pixel_mm, const ScanMarkOptions& options,
                                               const Run& run) {
  if (options.turned_deg % 90 != 0)
    return fail(Errc::kBadInput, "films lie turned by 0, 90, 180 or 270 degrees", {"turned_deg"_option});
  std::vector<fs::path> files;
  std::error_code error;
  if (fs::is_directory(path, error)) {
    for (const auto& entry : fs::directory_iterator(path, error))
      if (is_image_name(entry.path())) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
  } else {
    files.push_back(path);
  }
  if (files.empty()) return fail(Errc::kNotFound, path.string() + ": no scans (.tif, .jpg, .png) in it");
  std::optional<MarkModel> model;
  std::vector<ScanMarks> out;
  for (const fs::path& file : files) {
    COLLINEA_TRY(const GreyImage scan, read_grey(file));
    FiducialSearch search{
        .predicted = predicted_scan(calibration, scan.width, scan.height, pixel_mm, options.turned_deg / 90),
        .radius_mm = options.search_mm,
        .kind = options.mark_kind};
    if (out.empty()) {
      COLLINEA_TRY(model, learnt(scan, 1.4 * calibration.mark_size_mm * search.predicted.parameters[3], options));
    }
    search.learnt = model;
    const auto found = find_fiducials(scan, calibration, search, run);
    if (run.stop.stop_requested()) return fail(Errc::kCancelled, "stopped");
    if (found.empty())
      return fail(Errc::kNotFound,
                  fmt::format("{}: of {} marks fewer than three were found where the calibration has them",
                              file.string(), calibration.marks.size()),
                  {"turned_deg"_option, "search_mm"_option, "mark_kind"_option, "pixel_um"_option});
    ScanMarks marks{.image = file.stem().string()};
    for (const FoundFiducial& one : found) {
      marks.marks.push_back({one.name, one.mark.pixel, std::sqrt(one.mark.covariance.trace() / 2)});
      marks.least_correlation = std::min(marks.least_correlation, std::abs(one.mark.correlation));
    }
    out.push_back(std::move(marks));
  }
  return out;
}

}  // namespace collinea
