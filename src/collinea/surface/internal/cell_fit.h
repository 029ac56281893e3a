// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace collinea {

/// A point of the cloud near a cell of the surface model.
struct CellPoint {
  double x = 0, y = 0;  ///< from the centre of the cell, along columns and rows [cells]
  double height_m = 0;
  float sigma_m = 0;  ///< of the height, > 0
  bool own = false;   ///< it lies in the cell itself
};

struct CellEstimate {
  double height_m = 0;  ///< at the centre of the cell
  double sigma_m = 0;   ///< from the points' sigmas and scatter, and from their position on a slope
  int points = 0;       ///< that took part
};

/// How far from the centre of a cell points may have a say [cells]: pass all of them to CellFit.
constexpr double kCellReach = 2.0;

/// The share of the variance of points' errors that those which make one cell have in common, when errors at a distance
/// d are alike by exp(-d^2 / 2 L^2), L = `length_cells`; 0: none.
[[nodiscard]] double share_alike(double length_cells);

/// Finds the height of single cells. It only holds memory that is used again from cell to cell; the answer depends on
/// the arguments alone.
class CellFit {
 public:
  /// `alike`: see share_alike().
  explicit CellFit(double alike = 0) : alike_(alike) {}

  /// The surface seen from above at one cell: the uppermost level in the cell that has support around (roofs win over
  /// the walls and the ground below them, single high points lose), or, in a cell without points, the level of the
  /// nearest point; then a robust plane through the points of that level up to 1.5 cells away, weighted by their
  /// variance and a Gaussian of their distance. A plane is met exactly where the points fix its tilt. Nothing when no
  /// level has support.
  std::optional<CellEstimate> estimate(std::span<const CellPoint> near, double cell_m);

 private:
  struct Weighted {
    const CellPoint* point;
    double fixed_weight, weight, residual;
  };
  struct Plane {
    double at_centre = 0, slope_x = 0, slope_y = 0, leverage = 0;
    bool fixed = false;  // its tilt is; else it is level
  };

  std::optional<double> level(std::span<const CellPoint> near, double tolerance_m, double cell_m);
  std::optional<double> level_of_own(std::span<const CellPoint> near, double tolerance_m, double cell_m);
  std::optional<double> level_of_nearest(std::span<const CellPoint> near, double tolerance_m, double cell_m);
  void select(std::span<const CellPoint> near, double level_m, double tolerance_m, double cell_m, double reach);
  Plane fit_plane(double most_leverage) const;
  Plane fit_robustly(double floor_m, double most_leverage);
  double sigma_of(const Plane& plane, double cell_m) const;

  double alike_;
  std::vector<double> numbers_;
  std::vector<Weighted> used_;
};

}  // namespace collinea
