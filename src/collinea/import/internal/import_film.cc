// SPDX-License-Identifier: Apache-2.0
#include "collinea/import/internal/import_film.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>

#include "collinea/base/units.h"
#include "collinea/math/median.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;

// A scan whose marks miss by more than this, and by three times what those of others do, is called poor.
constexpr double kPoorRms_mm = 0.02, kPoorTimes = 3;

// Of the width of the image: the length of correlation that an adjustment begins with.
constexpr double kFirstCorrelation = 1.0 / 7;

// What the marks of a scan say of its deformation. An affine transformation takes its part of it; of another one with
// so few marks nothing is taken.
FilmPrior prior_of(const ScanOrientation& scan, const IdealImage& ideal) {
  FilmPrior prior{.mark_sigma_px = scan.mark_sigma_px * scan.pixel_mm() / ideal.pixel_mm};
  const FilmTransformation& scan_from_film = scan.scan_from_film();
  if (scan_from_film.model != FilmModel::kAffine) return prior;
  for (const FilmMarkResidual& mark : scan.choice.fit.marks) {
    if (!mark.is_used) continue;
    for (const CalibratedMark& known : ideal.calibration.marks) {
      if (known.name != mark.name) continue;
      const Eigen::Vector2d film_mm =
          known.film_mm + scan_from_film.by_film(known.film_mm).inverse() * mark.residual_px;
      const Eigen::Vector2d pixel = ideal.pixel_of(known.film_mm);
      prior.marks.push_back({pixel, ideal.pixel_of(film_mm) - pixel});
    }
  }
  return prior;
}

// Fills FilmFolder::deformed.
void find_deformation(const ImportOptions& options, FilmFolder& folder) {
  if (options.film_deformation_um == 0.0) return;
  const Camera& camera = folder.ideal.camera;
  const ImageExtent size{double(camera.width_px), double(camera.height_px)};
  std::vector<std::string> files;
  std::vector<FilmPrior> priors;
  for (const auto& [file, scan] : folder.scans)
    if (scan) files.push_back(file), priors.push_back(prior_of(*scan, folder.ideal));
  FilmPrior common{.correlation_px = kFirstCorrelation * camera.width_px};
  if (const auto& length_mm = options.film_correlation_mm) {
    common.correlation_px = *length_mm / folder.ideal.pixel_mm;
    common.correlation_is_given = true;
  }
  if (const auto& sigma_um = options.film_deformation_um) {
    common.sigma_px = 1e-3 * *sigma_um / folder.ideal.pixel_mm;
    common.sigma_is_given = true;
  } else if (const auto sigma_px = sigma_by_marks(priors, size, common.correlation_px)) {
    common.sigma_px = *sigma_px;
  } else {
    return;
  }
  for (std::size_t i = 0; i < files.size(); ++i) {
    FilmPrior& prior = folder.deformed[files[i]] = common;
    prior.mark_sigma_px = priors[i].mark_sigma_px;
    prior.marks = std::move(priors[i].marks);
  }
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
