// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string_view>

#include "collinea/base/words.h"

namespace collinea {

// Interior orientation of a scanned photograph: from image coordinates of the film [mm, x right, y up] to pixels of the
// scan [column, row, y down] by a transformation that is fitted to fiducial marks. With q = (x, -y), R(k) a rotation by
// k (from the column towards the row) and c the pixel of the film's origin:
//     rigid        3   pixel = c + R(k) q / p, p the given size of a pixel
//     similarity   4   pixel = c + m R(k) q
//     two scales   5   pixel = c + R(k) diag(mx, my) q
//     affine       6   pixel = c + R(k) [mx  my s; 0  my] q
//     projective   8   pixel = c + (R(k) [mx  my s; 0  my] q) / (1 + g q_x + h q_y)
// Each holds the ones before it. The two scales of the plotters, x = x0 + lx u cos a + ly v sin a (Franco 4, with the
// sign of the print corrected), lie along the axes of
// the comparator, here along those of the film, which is what shrinks. Of a photograph scanned from its back q = (x,
// y).

enum class FilmModel { kRigid, kSimilarity, kTwoScales, kAffine, kProjective };
inline constexpr Word<FilmModel> kFilmModelWords[] = {
    {FilmModel::kRigid, "rigid", "3 parameters: shift and rotation, the size of a pixel is given"},
    {FilmModel::kSimilarity, "similarity", "4: and one scale"},
    {FilmModel::kTwoScales, "two_scales", "5: a scale along each axis of the film"},
    {FilmModel::kAffine, "affine", "6: and a shear"},
    {FilmModel::kProjective, "projective", "8: and two of perspective"}};
[[nodiscard]] constexpr std::span<const Word<FilmModel>> words(FilmModel) { return kFilmModelWords; }
[[nodiscard]] int parameter_count(FilmModel model);

/// A parameter of a model by its place: "column", "row" [px], "rotation" [rad], "scale_x", "scale_y" [px/mm; of the
/// similarity "scale_x" stands for both], "shear" [1], "perspective_x", "perspective_y" [1/mm].
[[nodiscard]] std::string_view film_parameter_name(int parameter);
[[nodiscard]] std::string_view film_parameter_unit(int parameter);

/// A measured position with its covariance.
struct Position2 {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
};

/// The transformation with its parameters; a value.
struct FilmTransformation {
  FilmModel model = FilmModel::kSimilarity;
  bool is_mirrored = false;
  double scale_px_per_mm = 1;  ///< of the rigid one
  /// Of the model, in the order of film_parameter_name().
  Eigen::VectorXd parameters = Eigen::VectorXd::Zero(4);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(4, 4);

  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector2d& film_mm) const;
  /// By Newton's method, to rounding. Nothing beyond the horizon of a perspective.
  [[nodiscard]] std::optional<Eigen::Vector2d> film_of(const Eigen::Vector2d& pixel) const;
  /// The same with the covariance that the parameters give it [px^2].
  [[nodiscard]] Position2 pixel_with_covariance(const Eigen::Vector2d& film_mm) const;
  /// The same in mm^2, of the parameters and of the measurement of the pixel.
  [[nodiscard]] std::optional<Position2> film_with_covariance(const Eigen::Vector2d& pixel,
                                                              const Eigen::Matrix2d& pixel_covariance) const;
  /// Derivatives of pixel_of() by the parameters, and by the film coordinates.
  [[nodiscard]] Eigen::Matrix<double, 2, Eigen::Dynamic> by_parameters(const Eigen::Vector2d& film_mm) const;
  [[nodiscard]] Eigen::Matrix2d by_film(const Eigen::Vector2d& film_mm) const;
};

/// The route without marks: the pixel of the principal point of the film, and the size of a pixel (25.4 / dpi mm). The
/// columns of the scan are then the x axis of the film; its rotation on the scanner becomes part of kappa (Karfis 1.3).
[[nodiscard]] FilmTransformation without_marks(const Eigen::Vector2d& origin_pixel, double pixel_mm);

/// Which film coordinates of a mark the calibration defines. An edge of the frame that runs along y has x alone.
enum class MarkCoordinates { kBoth, kX, kY };
[[nodiscard]] constexpr int count_of(MarkCoordinates coordinates) {
  return coordinates == MarkCoordinates::kBoth ? 2 : 1;
}

}  // namespace collinea
