// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/scan_marks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "collinea/feature/fiducial_search.h"
#include "collinea/io/number_rows.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

FilmTransformation predicted(const GreyImage& scan, const MarkSearch& search) {
  return predicted_scan(search.calibration, scan.width, scan.height, search.pixel_mm, search.options.turned_deg / 90);
}

// The mark of the calibration that is predicted next to a position.
const CalibratedMark& nearest_mark(const FilmTransformation& predicted, const FilmCalibration& calibration,
                                   const Eigen::Vector2d& at) {
  return *std::min_element(calibration.marks.begin(), calibration.marks.end(), [&](const auto& a, const auto& b) {
    return (predicted.pixel_of(a.film_mm) - at).norm() < (predicted.pixel_of(b.film_mm) - at).norm();
  });
}

// A likeness from a position that was pointed to.
Result<LearntMark> learnt_at(std::string_view position, const GreyImage& scan, const MarkSearch& search) {
  const auto at = parse_numbers(position);
  if (!at || at->size() != 2)
    return fail(Errc::kBadInput, "the position of the mark is not two numbers with a comma between",
                {"mark_at"_option});
  const FilmTransformation near = predicted(scan, search);
  const double px_per_mm = near.parameters[3];
  const Eigen::Vector2d pixel((*at)[0], (*at)[1]);
  auto learnt = learnt_mark(scan, pixel, 1.4 * search.calibration.mark_size_mm * px_per_mm);
  if (!learnt || search.calibration.marks.empty())
    return fail(Errc::kBadInput, "nothing that could be a mark lies there in the first scan", {"mark_at"_option});
  learnt->mark = nearest_mark(near, search.calibration, pixel);
  if (!((near.pixel_of(learnt->mark.film_mm) - pixel).norm() <= search.options.search_mm * px_per_mm))
    return fail(Errc::kBadInput, "the calibration has no mark near the position that was pointed to",
                {"mark_at"_option, "search_mm"_option, "turned_deg"_option});
  return *std::move(learnt);
}

}  // namespace

Result<MarkSearch> mark_search(const FilmCalibration& calibration, std::optional<double> pixel_mm,
                               const ScanMarkOptions& options, const fs::path& first_scan) {
  if (options.turned_deg % 90 != 0)
    return fail(Errc::kBadInput, "films lie turned by 0, 90, 180 or 270 degrees", {"turned_deg"_option});
  MarkSearch search{calibration, pixel_mm, options};
  if (options.mark_at) {
    COLLINEA_TRY(const GreyImage scan, read_grey(first_scan));
    std::string_view rest = *options.mark_at;
    for (bool is_last = false; !is_last;) {
      const std::size_t end = rest.find(';');
      is_last = end == std::string_view::npos;
      COLLINEA_TRY(LearntMark learnt, learnt_at(rest.substr(0, end), scan, search));
      search.learnt.push_back(std::move(learnt));
      if (!is_last) rest.remove_prefix(end + 1);
    }
  }
  return search;
}

Result<ScanMarks> find_marks(const GreyImage& scan, const std::string& name, const MarkSearch& search, const Run& run) {
  const auto found = find_fiducials(scan, search.calibration,
                                    {.predicted = predicted(scan, search),
                                     .radius_mm = search.options.search_mm,
                                     .kind = search.options.mark_kind,
                                     .learnt = search.learnt},
                                    run);
  if (run.stop.stop_requested()) return fail(Errc::kCancelled, "stopped");
  if (found.empty())
    return fail(Errc::kNotFound,
                fmt::format("of {} marks fewer than three were found where the calibration has them",
                            search.calibration.marks.size()),
                {"turned_deg"_option, "search_mm"_option, "mark_kind"_option});
  ScanMarks marks{.image = name};
  for (const FoundFiducial& one : found) {
    marks.marks.push_back({one.name, one.mark.pixel, std::sqrt(one.mark.covariance.trace() / 2)});
    marks.least_correlation = std::min(marks.least_correlation, std::abs(one.mark.correlation));
  }
  return marks;
}

bool is_scan(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored) || is_image_name(path);
}

Result<std::vector<ScanMarks>> find_scan_marks(const fs::path& path, const FilmCalibration& calibration,
                                               std::optional<double> pixel_mm, const ScanMarkOptions& options,
                                               const Run& run) {
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
  COLLINEA_TRY(const MarkSearch search, mark_search(calibration, pixel_mm, options, files.front()));
  std::vector<ScanMarks> out;
  for (const fs::path& file : files) {
    COLLINEA_TRY(const GreyImage scan, read_grey(file));
    COLLINEA_TRY(ScanMarks marks, find_marks(scan, file.stem().string(), search, run).map_error([&](Error e) {
      return std::move(e).within(file.string()).about("pixel_um"_option);
    }));
    out.push_back(std::move(marks));
  }
  return out;
}

}  // namespace collinea
