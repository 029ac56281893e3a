// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/feature/edge_fit.h"

// Hough transform (Hough 1962, Duda and Hart 1972): every edge point votes for the curves that may pass through it; the
// direction of its gradient leaves few of them (Ballard 1981). A maximum of the votes is only where a curve may be: it
// is then adjusted by least squares over its points, which vote no more. Robust to gaps and to points of other curves.
namespace collinea {

struct HoughOptions {
  int least_points = 25;
  int most = 200;
  double tolerance_px = 1.0;
  double smallest_radius_px = 5, largest_radius_px = 100;
  double least_arc = 0.5;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = HoughOptions;
    visit(Field{"least_points", &O::least_points, "1", "of a line or a circle, edge points", 5, 1e6});
    visit(Field{"most", &O::most, "1", "lines, circles or shapes that are looked for", 1, 1e5});
    visit(
        Field{"tolerance_px", &O::tolerance_px, "px", "largest distance of a point from its line or circle", 0.1, 20});
    visit(Field{"smallest_radius_px", &O::smallest_radius_px, "px", "of circles", 2, 1e5});
    visit(Field{"largest_radius_px", &O::largest_radius_px, "px", "of circles", 2, 1e5});
    visit(Field{"least_arc", &O::least_arc, "1", "part of a circle or an ellipse that must have edge points", 0.1, 1});
  }
};

/// The edge points of an image that vote, and how they are correlated.
struct EdgePoints {
  std::span<const EdgePoint> points;
  int width = 0, height = 0;  ///< of the image
  double along_px = 1;
};
[[nodiscard]] inline EdgePoints edge_points_of(const EdgeMap& map) {
  return {map.points, map.amplitude.width, map.amplitude.height, map.along_px};
}

struct FoundLine {
  EdgeLine line;
  std::vector<std::size_t> points;  ///< their numbers
};
/// Straight lines, those of most points first. Votes in cells of 0.5 degrees and 1 px.
[[nodiscard]] std::vector<FoundLine> hough_lines(const EdgePoints& edges, const HoughOptions& options);

struct FoundCircle {
  EdgeCircle circle;
  std::vector<std::size_t> points;
};
/// Circles, bright and dark ones, those of most votes first. A centre is voted for along the gradient of each point,
/// between the two radii and on both sides; its radius is then the most frequent one.
[[nodiscard]] std::vector<FoundCircle> hough_circles(const EdgePoints& edges, const HoughOptions& options);

/// Any shape, as edge points about a reference point: the R-table of Ballard (1981).
class ShapeTable {
 public:
  /// The shape that these edge points draw. Nothing from fewer than five.
  static std::optional<ShapeTable> create(std::span<const EdgePoint> shape, const Eigen::Vector2d& reference);

  struct Entry {
    Eigen::Vector2d from_reference, normal;
  };
  [[nodiscard]] std::span<const Entry> entries() const { return entries_; }
  /// The entries whose normal lies in that direction, to 3 degrees.
  [[nodiscard]] std::span<const std::size_t> at_direction(double angle_rad) const;
  [[nodiscard]] double radius_px() const { return radius_px_; }

 private:
  static constexpr int kBins = 120;
  std::vector<Entry> entries_;
  std::array<std::vector<std::size_t>, kBins> bins_;
  double radius_px_ = 0;
};

/// The rotations and scales that a shape may have; one of each: known, and not estimated.
struct ShapeSearch {
  std::vector<double> rotations_rad = {0};
  std::vector<double> scales = {1};
  double least_share = 0.5;  ///< of the shape's points must be found
};
/// Rotations of -largest .. largest [rad] (beyond half a turn: all) and scales of smallest .. largest, both included,
/// so near to each other that between two of them no point of the shape moves by more than 4 px, twice a cell of the
/// votes. One of each where the range is none. The scales grow by one factor: half and twice the size are as far away.
[[nodiscard]] ShapeSearch shape_search(const ShapeTable& shape, double largest_rotation_rad, double smallest_scale,
                                       double largest_scale);

struct FoundShape {
  Eigen::Vector2d at = {};  ///< of the reference point [px]
  double rotation_rad = 0, scale = 1;
  /// Of x, y [px], and then of rotation [rad] and of scale [1] where these were searched.
  Eigen::MatrixXd covariance;
  double share = 0;  ///< of the shape's points that were found
  EdgeFitQuality quality;
};
/// Where a shape is, adjusted over the edge points that are within the tolerance of it; its own points are taken as
/// exact. Best first, one at each position. None: fewer than the least share of its points have edge points, and what
/// the adjustment takes beyond the rotations and scales searched, by more than a step between them. A shape
/// whose normals all point to its reference point (a disc) determines no rotation: none where rotations are searched.
[[nodiscard]] std::vector<FoundShape> hough_shapes(const EdgePoints& edges, const ShapeTable& shape,
                                                   const ShapeSearch& search, const HoughOptions& options);

}  // namespace collinea
