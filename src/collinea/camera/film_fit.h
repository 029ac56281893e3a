// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "collinea/camera/film_transformation.h"

namespace collinea {

/// A fiducial mark: where the calibration has it and where it was measured.
struct FilmMark {
  std::string name;
  Eigen::Vector2d film_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Identity();  ///< of the pixel [px^2]
  double calibration_sigma_mm = 0;                           ///< of film_mm, each coordinate
  MarkCoordinates coordinates = MarkCoordinates::kBoth;      ///< the other of film_mm is about where the mark is
};

/// What the fit says of a mark.
struct FilmMarkResidual {
  std::string name;
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();  ///< measured minus transformed
  Eigen::Vector2d w = Eigen::Vector2d::Zero();            ///< residual over its sigma (tau, where sigmas are unknown)
  Eigen::Vector2d redundancy = Eigen::Vector2d::Zero();
  double misread_chance = 1;  ///< of such residuals of a good mark: chi-squared or F test of both coordinates
  bool is_used = true;        ///< false: rejected as misread; the residual is that of a check
  MarkCoordinates coordinates = MarkCoordinates::kBoth;  ///< one: the residual is across that line of the film alone
};

struct FilmFitOptions {
  bool sigmas_are_known = false;   ///< else covariances are scaled by sigma0
  double level = 0.001;            ///< of the test for a misread mark, of all marks together
  bool reject_misread = true;      ///< one at a time, while two degrees of freedom remain
  std::optional<double> pixel_mm;  ///< given size of a pixel: the rigid model needs it
};

/// A fitted transformation with what tells how good it is.
struct FilmFit {
  FilmTransformation transformation;
  double squares = 0;  ///< weighted sum of squared residuals
  int redundancy = 0;
  double sigma0 = 1;  ///< sqrt(squares / redundancy); 1 without redundancy
  std::vector<FilmMarkResidual> marks;
};

/// Weighted least squares: measured pixels are the observations, those of the calibration enter by their sigma. Rank
/// defects are those of the marks: fewer coordinates than parameters, all marks on a line (two scales and more), three
/// of four on one (projective), no size of a pixel (rigid). Then nothing. Whether the scan is mirrored is found by the
/// similarity that fits better.
///
/// A mark of one coordinate gives one equation. With u the coordinate that it lacks and n the unit vector across
/// dpixel/du, n' (pixel - pixel_of(film)) is left of it, film with the u that the pixel itself tells: u as an unknown
/// of its own, eliminated. Its variance is n' C n and the calibration's of its coordinate. The w of its one coordinate
/// stands at the pixel axis nearer to n, its redundancy is shared out as n_x^2 and n_y^2. Marks in the middle of four
/// sides that give one coordinate each determine shift and rotation with one redundant equation, but no scale.
[[nodiscard]] std::optional<FilmFit> fit_film(std::span<const FilmMark> marks, FilmModel model,
                                              const FilmFitOptions& options);

/// A smaller model against a larger one that holds it: F test, or chi-squared where sigmas are known.
struct FilmModelTest {
  FilmModel smaller{}, larger{};
  double statistic = 0;  ///< F; chi-squared over its degrees of freedom where sigmas are known
  double chance = 1;     ///< of a larger one if the smaller model holds
};

struct FilmChoice {
  FilmFit fit;                       ///< of the model that was chosen
  std::vector<FilmModelTest> tests;  ///< of every pair that has redundancy
};

/// The smallest model that none of the larger ones rejects, at the level `level` for all tests against it together. All
/// are fitted to the same marks: those that stay when the affine model (or the largest that the marks allow) rejects
/// the misread ones. Where nothing can be tested, the smallest that is determined. Nothing when not even a similarity
/// is.
[[nodiscard]] std::optional<FilmChoice> choose_film_model(std::span<const FilmMark> marks,
                                                          const FilmFitOptions& options, double level = 0.05);

/// A value with its standard deviation.
struct WithSigma {
  double value = 0, sigma = 0;
};

/// What happened to film and scan between camera and pixels, by the affine transformation.
struct FilmDeformation {
  WithSigma pixel_x_um, pixel_y_um;          ///< size of a pixel along the axes of the film, if the film is undeformed
  WithSigma difference_ppm;                  ///< scale in x over scale in y, less 1
  WithSigma shear_ppm;                       ///< of the angle between the axes, 1e-6 rad
  WithSigma rotation_rad;                    ///< of the film on the scanner, columns towards rows
  std::optional<WithSigma> x_ppm, y_ppm;     ///< against the given size of a pixel
  bool differs = false, is_sheared = false;  ///< difference and shear beyond what chance makes of none (level 0.05)
};
[[nodiscard]] std::optional<FilmDeformation> film_deformation(std::span<const FilmMark> marks,
                                                              const FilmFitOptions& options);

}  // namespace collinea
