// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/quality/systematics.h"

namespace collinea::bundle {

/// A hypothesis as the columns of H that it adds to the design matrix: derivatives of computed observations by its
/// parameters. Columns are numbered over all hypotheses, see HypothesisColumns.
struct Hypothesis {
  SystematicTest test;          ///< kind, owner and units
  std::vector<int> columns;     ///< that it is a combination of
  Eigen::MatrixXd combination;  ///< its parameters by these columns, columns.size() x parameters; empty: each is one
  [[nodiscard]] Eigen::Index parameters() const {
    return combination.size() > 0 ? combination.cols() : static_cast<Eigen::Index>(columns.size());
  }
};

/// The derivative of one observation by one column.
struct ColumnPart {
  int column;
  double derivative;
};

/// Functions of the position in the image that every set of additional parameters consists of, for the columns and for
/// the rows of the camera alike: monomials and waves of normalised coordinates.
class PixelFunctions {
 public:
  static constexpr int kMost = 33;
  /// `with_gruen`: monomials up to the fourth degree in either coordinate instead of those of the smaller sets.
  explicit PixelFunctions(bool with_gruen);
  [[nodiscard]] int count() const { return count_; }
  /// The number of the monomial x^a y^b, which is there.
  [[nodiscard]] int number_of(int a, int b) const;
  /// Their values at a pixel; out has count() elements.
  void at(const ImageExtent& size, const double* pixel, double* out) const;
  /// The parameters of a set by the functions (2 count(), first those of columns, then of rows). Nothing when they do
  /// not span the set.
  [[nodiscard]] std::optional<Eigen::MatrixXd> combination_of(AdditionalSet set, const ImageExtent& size) const;

 private:
  std::vector<std::array<int, 2>> powers_;
  int count_;
};

/// Columns of hypotheses about one camera in its images: first those of PixelFunctions (columns, rows), then that of
/// the rolling shutter.
struct CameraColumns {
  int camera;  ///< index in Problem::cameras
  int first;   ///< number of its first column
  ImageExtent size;
};

/// All columns in their order: those of positions and attitudes, of each camera, of refraction, of the bowl and last
/// the residual, which is treated as one of them.
struct HypothesisColumns {
  HypothesisColumns(const Solved& solved, const SystematicOptions& options);

  [[nodiscard]] int per_camera() const { return 2 * functions.count() + 1; }
  [[nodiscard]] int refraction() const { return first_image_column + per_camera() * static_cast<int>(cameras.size()); }
  [[nodiscard]] int bowl() const { return refraction() + 1; }
  [[nodiscard]] int residual() const { return bowl() + 1; }
  [[nodiscard]] int count() const { return residual() + 1; }

  /// Non-zero derivatives of one coordinate of an item of Problem::positions or of Problem::attitudes.
  [[nodiscard]] const std::vector<ColumnPart>& of_position(std::size_t item, int axis) const {
    return positions[item][static_cast<std::size_t>(axis)];
  }
  [[nodiscard]] const std::vector<ColumnPart>& of_attitude(std::size_t item, int axis) const {
    return attitudes[item][static_cast<std::size_t>(axis)];
  }
  /// Relative height of the bowl at a position of the world.
  [[nodiscard]] double bowl_at(const Eigen::Vector3d& position) const;

  const Problem& problem;
  const State& state;
  PixelFunctions functions;
  std::vector<Hypothesis> hypotheses;
  std::vector<CameraColumns> cameras;
  std::vector<int> slot_of_camera;  ///< index in `cameras` of each of Problem::cameras; -1: none
  int first_image_column = 0;
  std::vector<Eigen::Vector3d> velocity;   ///< of each image of the problem, zero where not known [m/s or m/interval]
  std::vector<double> raise_per_square_m;  ///< refraction raises a point by this times its squared distance; by image
  bool has_bowl = false;
  Eigen::Vector2d bowl_middle = Eigen::Vector2d::Zero();
  double bowl_radius_m = 1;
  std::vector<std::array<std::vector<ColumnPart>, 3>> positions, attitudes;  ///< parallel to those of the problem
};

}  // namespace collinea::bundle
