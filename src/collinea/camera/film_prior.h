// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/camera/additional.h"

namespace collinea {

// The local deformation of film, of every photograph another: each coordinate z of the displacement is a stationary
// process,
//
//     E z(p) z(q) = sigma^2 exp(-|p - q|^2 / (2 l^2)),
//
// of which the affine transformation of the marks has taken what it can: g = z - H (z + n) at the marks, n the errors
// of their measurement. What the marks left as residuals is known. Of g the functions of AdditionalSet::kFilm have a
// normal distribution, by which they enter an adjustment.

/// A fiducial mark in an image: where it lies, and by how much farther it was found than its transformation has it.
struct FilmMarkOffset {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero(), offset_px = Eigen::Vector2d::Zero();

  friend bool operator==(const FilmMarkOffset&, const FilmMarkOffset&) = default;
};

/// What is known of the deformation of one scan before an adjustment.
struct FilmPrior {
  double sigma_px = 0;                                        ///< of each coordinate
  double correlation_px = 0;                                  ///< l
  double mark_sigma_px = 0;                                   ///< of a coordinate of a mark
  bool sigma_is_given = false, correlation_is_given = false;  ///< else they may be estimated
  int functions = int(kFilmFunctions);                        ///< how many take part, the first ones
  /// Those that the affine transformation was fitted to; none: it takes no part, all of the process is in the image.
  std::vector<FilmMarkOffset> marks;

  friend bool operator==(const FilmPrior&, const FilmPrior&) = default;
};

/// The functions of a process with sigma = 1 and what the marks see of it: covariances by the positions of the marks
/// alone, which the scans of a camera share.
struct FilmShape {
  Eigen::MatrixXd functions;     ///< of the functions
  Eigen::MatrixXd with_marks;    ///< of functions and contrasts of the marks
  Eigen::MatrixXd contrasts;     ///< of the contrasts
  Eigen::MatrixXd by_marks;      ///< of the functions, by errors of the marks of size 1
  Eigen::MatrixXd of_residuals;  ///< the contrasts by the residuals: orthonormal rows, no affinity
};
[[nodiscard]] FilmShape film_shape(const FilmPrior& prior, ImageExtent size, double correlation_px);

/// The distribution of the functions given the residuals of the marks: the means of column and row, and the covariance
/// of each of them (column and row are independent).
struct FilmField {
  Eigen::VectorXd column, row;  ///< [px]
  Eigen::MatrixXd covariance;   ///< [px^2]
};
[[nodiscard]] FilmField film_field(const FilmPrior& prior, const FilmShape& shape);

/// What an adjustment says of the functions of one scan.
struct FilmMoments {
  FilmPrior prior;
  Eigen::VectorXd values;      ///< [px], as in Camera::params
  Eigen::MatrixXd covariance;  ///< [px^2], after the adjustment
};

struct FilmProcess {
  double sigma_px = 0, correlation_px = 0;
};

/// The process under which marks and functions are likeliest, as the step of expectation and maximisation does it
/// (Dempster, Laird, Rubin 1977): values with their uncertainty in place of those that are not known. Repeated with
/// adjustments between, it comes to the likelihood's maximum of marks and measurements. What is given in the priors
/// stays. Correlation between a 25th and a half of the image.
[[nodiscard]] FilmProcess likeliest_process(std::span<const FilmMoments> scans, ImageExtent size);

/// The standard deviation of the process by residuals of marks alone, the length given: sum of squares less what errors
/// of measurement bring, over what a process of size 1 leaves in residuals. Nothing where there is no residual too
/// many, or no deformation beyond those errors.
[[nodiscard]] std::optional<double> sigma_by_marks(std::span<const FilmPrior> scans, ImageExtent size,
                                                   double correlation_px);

}  // namespace collinea
