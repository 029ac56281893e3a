// SPDX-License-Identifier: Apache-2.0
#include "collinea/jobs/internal/pair_film.h"

namespace collinea {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector2d;

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
  if (options.principal_distance_px || options.principal_point_px || options.camera)
    return fail(Errc::kBadInput, "the camera of film is that of its calibration",
                {"principal_distance_px"_option, "principal_point_px"_option, "camera"_option, "film"_option});
  COLLINEA_TRY(const MarkSearch search, film_search(options.film, left));
  PairFilm film;
  for (const auto& [file, scan] : {std::pair(left, &film.left), std::pair(right, &film.right)}) {
    COLLINEA_TRY(*scan, orient_scan(file, search, run).map_error([&](Error error) {
      return std::move(error).within(file.string());
    }));
  }
  film.ideal = ideal_image(search.calibration, 0.5 * (film.left.pixel_mm() + film.right.pixel_mm()));
  film.left_file = folder / "film_left.jpg";
  film.right_file = folder / "film_right.jpg";
  COLLINEA_TRY(write_ideal_image(left, film.left.scan_from_film(), film.ideal, film.left_file, run));
  COLLINEA_TRY(write_ideal_image(right, film.right.scan_from_film(), film.ideal, film.right_file, run));
  return film;
}

}  // namespace collinea
