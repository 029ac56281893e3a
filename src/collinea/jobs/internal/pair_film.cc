// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_film.h"

#include "collinea/io/film_calibration_file.h"
#include "collinea/raster/image_file.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

Result<ScanOrientation> oriented(const fs::path& file, const MarkSearch& search, const Run& run) {
  const auto within = [&](Error error) { return std::move(error).within(file.string()); };
  COLLINEA_TRY(const GreyImage scan, read_grey(file));
  COLLINEA_TRY(const ScanMarks marks, find_marks(scan, file.stem().string(), search, run).map_error(within));
  return oriented_scan(search.calibration, marks).map_error(within);
}

std::optional<Vector2d> in_ideal(const ScanOrientation& scan, const IdealImage& ideal, const Vector2d& scan_px) {
  const auto film_mm = scan.scan_from_film().film_of(scan_px);
  if (!film_mm) return std::nullopt;
  return ideal.pixel_of(*film_mm);
}

}  // namespace

std::optional<Vector2d> PairFilm::in_left(const Vector2d& scan_px) const { return in_ideal(left, ideal, scan_px); }
std::optional<Vector2d> PairFilm::in_right(const Vector2d& scan_px) const { return in_ideal(right, ideal, scan_px); }

Result<PairFilm> pair_film(const fs::path& left, const fs::path& right, const fs::path& folder,
                           const PairChainOptions& options, const Run& run) {
  if (options.principal_distance_px || options.principal_point_px)
    return fail(Errc::kBadInput, "the camera of film is that of its calibration",
                {"principal_distance_px"_option, "principal_point_px"_option, "film"_option});
  COLLINEA_TRY(const FilmCalibration calibration, read_film_calibration(*options.film));
  std::optional<double> pixel_mm;
  if (options.film_pixel_um) pixel_mm = 1e-3 * *options.film_pixel_um;
  COLLINEA_TRY(const MarkSearch search, mark_search(calibration, pixel_mm, options.film_marks, left));
  PairFilm film;
  COLLINEA_TRY(film.left, oriented(left, search, run));
  COLLINEA_TRY(film.right, oriented(right, search, run));
  film.ideal = ideal_image(calibration, 0.5 * (film.left.pixel_mm() + film.right.pixel_mm()));
  film.left_file = folder / "film_left.jpg";
  film.right_file = folder / "film_right.jpg";
  COLLINEA_TRY(write_ideal_image(left, film.left.scan_from_film(), film.ideal, film.left_file, run));
  COLLINEA_TRY(write_ideal_image(right, film.right.scan_from_film(), film.ideal, film.right_file, run));
  return film;
}

}  // namespace collinea
