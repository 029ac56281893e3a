// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "collinea/adjust/solved.h"
#include "collinea/quality/internal/pixel_functions.h"
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
  HypothesisColumns(const Problem& of, const State& at, bool with_gruen)
      : problem(of), state(at), functions(with_gruen) {}

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
  /// The index in Problem::cameras of the camera that deforms its images by an affinity or additional parameters; -1 of
  /// other tests.
  [[nodiscard]] int camera_with_deformation(const SystematicTest& test) const {
    if (test.kind != SystematicKind::kAffinity && test.kind != SystematicKind::kAdditional) return -1;
    for (const CameraColumns& its : cameras)
      if (problem.cameras[static_cast<std::size_t>(its.camera)].id == test.camera) return its.camera;
    return -1;
  }
  /// Relative height of the bowl at a position of the world.
  [[nodiscard]] double bowl_at(const Eigen::Vector3d& position) const {
    return (position.head<2>() - bowl_middle).squaredNorm() / (bowl_radius_m * bowl_radius_m);
  }

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
