// SPDX-License-Identifier: Apache-2.0
#include "collinea/film/scan_deformation.h"

#include <Eigen/LU>

namespace collinea {
namespace {

constexpr double kFirstCorrelation = 1.0 / 7;  // of the width of the image

// The marks of a scan in the ideal image, with their residuals there.
FilmPrior prior_of(const ScanOrientation& scan, const IdealImage& ideal) {
  FilmPrior prior{.mark_sigma_px = scan.mark_sigma_px * scan.pixel_mm() / ideal.pixel_mm};
  const FilmTransformation& scan_from_film = scan.scan_from_film();
  if (scan_from_film.model != FilmModel::kAffine) return prior;
  for (const FilmMarkResidual& mark : scan.choice.fit.marks) {
    if (!mark.is_used || mark.coordinates != MarkCoordinates::kBoth) continue;
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

}  // namespace

std::vector<FilmPrior> scan_deformation(std::span<const ScanOrientation* const> scans, const IdealImage& ideal,
                                        const GivenDeformation& given) {
  if (given.sigma_mm == 0.0) return {};
  std::vector<FilmPrior> priors;
  for (const ScanOrientation* scan : scans) priors.push_back(prior_of(*scan, ideal));
  const Camera& camera = ideal.camera;
  const double correlation_px =
      given.correlation_mm ? *given.correlation_mm / ideal.pixel_mm : kFirstCorrelation * camera.width_px;
  std::optional<double> sigma_px;
  if (given.sigma_mm)
    sigma_px = *given.sigma_mm / ideal.pixel_mm;
  else
    sigma_px = sigma_by_marks(priors, {double(camera.width_px), double(camera.height_px)}, correlation_px);
  if (!sigma_px) return {};
  for (FilmPrior& prior : priors) {
    prior.sigma_px = *sigma_px;
    prior.correlation_px = correlation_px;
    prior.sigma_is_given = given.sigma_mm.has_value();
    prior.correlation_is_given = given.correlation_mm.has_value();
  }
  return priors;
}

}  // namespace collinea
