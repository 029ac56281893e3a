// SPDX-License-Identifier: Apache-2.0
#include "collinea/quality/film_estimate.h"

#include <algorithm>
#include <cmath>

namespace collinea {
namespace {

constexpr int kMostAdjustments = 12;
constexpr double kUnchanged = 0.02;
constexpr int kMostFilmUnknowns = 6000;  // of all scans: 0.3 GB of normal equations

std::vector<FilmMoments> moments_of(const Block& block, const Examined& adjusted) {
  const double variance = std::pow(sigma_scale(adjusted), 2);
  std::vector<FilmMoments> all;
  for (const auto& [id, covariance] : adjusted.camera_covariance) {
    const Camera& camera = block.cameras.at(id);
    if (!is_deformed_film(camera)) continue;
    const Eigen::Index count = 2 * camera.prior.film->functions;
    all.push_back({*camera.prior.film,
                   Eigen::Map<const Eigen::VectorXd>(adjusted.cameras.at(id).params.data() + Camera::kParams, count),
                   variance * covariance.block(Camera::kParams, Camera::kParams, count, count)});
  }
  return all;
}

// The root mean square of the deformation over the images of all scans.
double rms_px(const Block& block) {
  constexpr int kGrid = 12;
  double squares = 0;
  long count = 0;
  for (const auto& [id, camera] : block.cameras) {
    if (!is_deformed_film(camera)) continue;
    const ImageExtent size{double(camera.width_px), double(camera.height_px)};
    for (int i = 0; i < kGrid; ++i)
      for (int k = 0; k < kGrid; ++k, count += 2)
        squares += additional_shift(AdditionalSet::kFilm, camera.params.data() + Camera::kParams, size,
                                    {size.width_px * (i + 0.5) / kGrid, size.height_px * (k + 0.5) / kGrid})
                       .shift_px.squaredNorm();
  }
  return count > 0 ? std::sqrt(squares / double(count)) : 0;
}

}  // namespace

void add_film(Block& block) {
  std::size_t scans = 0;
  for (const auto& [id, camera] : block.cameras) scans += camera.prior.film.has_value();
  int functions = 0;
  for (int degree = 0; degree <= 6; ++degree) {
    const int more = (degree + 1) * (degree + 2) / 2;
    if (2 * more * int(scans) <= kMostFilmUnknowns) functions = more;
  }
  for (auto& [id, camera] : block.cameras) {
    if (!camera.prior.film || functions == 0) continue;
    if (camera.additional != AdditionalSet::kFilm)
      std::fill(camera.params.begin() + Camera::kParams, camera.params.end(), 0.0);
    camera.additional = AdditionalSet::kFilm;
    camera.prior.film->functions = functions;
  }
}

bool film_takes_part(const Block& block) {
  return std::any_of(block.cameras.begin(), block.cameras.end(),
                     [](const auto& one) { return is_deformed_film(one.second); });
}

Result<FilmEstimate> estimate_film(Block& block, const AdjustScope& scope, const ExamineOptions& options,
                                   const Run& run) {
  FilmEstimate found;
  ExamineOptions asked = options;
  asked.reliability = asked.point_covariances = asked.systematics.test = false;
  Adjuster adjuster;
  const AdjustScope around = with_first_cameras(scope, block.cameras);
  for (;; ++found.iterations) {
    COLLINEA_TRY(const Examined adjusted, examine(adjuster, block, around, asked, run));
    apply(adjusted, block);
    found.rms_px = rms_px(block);
    const std::vector<FilmMoments> scans = moments_of(block, adjusted);
    if (scans.empty()) return found;
    const FilmPrior& now = scans.front().prior;
    found.process = {now.sigma_px, now.correlation_px};
    if (found.iterations == 0) found.before = found.process;
    if (now.sigma_is_given && now.correlation_is_given) return found;
    const Camera& camera = block.cameras.at(adjusted.camera_covariance.begin()->first);
    const FilmProcess next = likeliest_process(scans, {double(camera.width_px), double(camera.height_px)});
    found.converged = std::abs(std::log(next.sigma_px / now.sigma_px)) < kUnchanged &&
                      std::abs(std::log(next.correlation_px / now.correlation_px)) < kUnchanged;
    if (found.converged || found.iterations == kMostAdjustments) return found;
    for (auto& [id, one] : block.cameras)
      if (is_deformed_film(one)) {
        one.prior.film->sigma_px = next.sigma_px;
        one.prior.film->correlation_px = next.correlation_px;
      }
  }
}

}  // namespace collinea
