// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_film.h"

#include <fmt/format.h>

#include <algorithm>

#include "collinea/base/units.h"
#include "collinea/film/scan_deformation.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// A scan whose marks miss by more than this, and by three times what those of others do, is called poor.
constexpr double kPoorRms_mm = 0.02, kPoorTimes = 3;

// Fills FilmFolder::deformed.
void find_deformation(const ImportOptions& options, FilmFolder& folder) {
  GivenDeformation given;
  if (options.film_deformation_um) given.sigma_mm = 1e-3 * *options.film_deformation_um;
  given.correlation_mm = options.film_correlation_mm;
  std::vector<std::string> files;
  std::vector<const ScanOrientation*> scans;
  for (const auto& [file, scan] : folder.scans)
    if (scan) files.push_back(file), scans.push_back(&*scan);
  std::vector<FilmPrior> priors = scan_deformation(scans, folder.ideal, given);
  for (std::size_t i = 0; i < priors.size(); ++i) folder.deformed.emplace(files[i], std::move(priors[i]));
}

}  // namespace

ImageHeader FilmFolder::header() const {
  ImageHeader header;
  header.width_px = ideal.camera.width_px;
  header.height_px = ideal.camera.height_px;
  return header;
}

Result<FilmFolder> film_folder(const fs::path& photos, const std::vector<std::string>& files,
                               const ImportOptions& options, const Run& run) {
  if (files.empty()) return FilmFolder{};  // what is missing is said of every folder
  if (options.camera_params)
    return fail(Errc::kBadInput, "the camera of film is that of its calibration",
                {"camera_params"_option, "film"_option});
  COLLINEA_TRY(const MarkSearch search, film_search(options.film, photos / files.front()));
  std::vector<Result<ScanOrientation>> oriented(files.size(), fail(Errc::kNotFound, "not read"));
  UnitList list{.stage = "fiducial marks"};
  for (std::size_t i = 0; i < files.size(); ++i) list.units.push_back(Unit::file(i));
  const auto work = [&](std::size_t i, const Run& one) -> Result<UnitWorked> {
    oriented[i] = orient_scan(photos / files[i], search, one);
    return UnitWorked{};
  };
  COLLINEA_TRY(run_units(run, list, {.work = work}));
  FilmFolder folder;
  std::vector<double> sizes_mm;
  const Error* first = nullptr;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (oriented[i]) sizes_mm.push_back(oriented[i]->pixel_mm());
    if (!oriented[i] && !first) first = &oriented[i].error();
  }
  if (sizes_mm.empty()) {
    Error none = *first;
    return tl::unexpected(std::move(none)
                              .within(fmt::format("{}: of {} files no one shows the marks of the film; the first: {}",
                                                  photos.string(), files.size(), files.front()))
                              .about("film"_option));
  }
  folder.ideal = ideal_image(search.calibration, median(sizes_mm));
  for (std::size_t i = 0; i < files.size(); ++i) folder.scans.emplace(files[i], std::move(oriented[i]));
  find_deformation(options, folder);
  return folder;
}

void name_poor_scans(Imported& imported) {
  std::vector<double> all_mm;
  for (const auto& [id, scan] : imported.film->scans) all_mm.push_back(scan.rms_mm());
  const double usual_mm = median(all_mm);
  for (const auto& [id, scan] : imported.film->scans)
    if (scan.rms_mm() > std::max(kPoorRms_mm, kPoorTimes * usual_mm) || scan.misread() > 0)
      imported.findings.push_back(finding_of(FindingCode::kScanMarksDisagree, {id},
                                             {{FigureName::kOffsetPx, scan.rms_mm() / scan.pixel_mm()},
                                              {FigureName::kCount, double(scan.misread())},
                                              {FigureName::kOf, double(scan.marks)}}));
}

}  // namespace collinea
