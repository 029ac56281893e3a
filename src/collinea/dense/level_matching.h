// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/base/run.h"
#include "collinea/dense/level_point.h"
#include "collinea/raster/raster.h"

namespace collinea {

struct LevelOptions {
  double first_threshold = 20'000, last_threshold = 1000;
  int levels = 7;
  int template_px = 21;
  double min_ncc = 0.8;
  double square_px = 100;
  double return_px = 1.5;
  int grid_px = 0;
  int grid_template_px = 13;
  double min_entropy = 4;
  double whole_mpx = 16;

  friend bool operator==(const LevelOptions&, const LevelOptions&) = default;

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = LevelOptions;
    visit(Field{"first_threshold", &O::first_threshold, "",
                "of the first level: least corner measure of a point (det / trace of Prewitt gradients)", 0, 1e9});
    visit(Field{"last_threshold", &O::last_threshold, "", "of the last level", 0, 1e9});
    visit(Field{"levels", &O::levels, "", "levels of falling threshold", 1, 50});
    visit(Field{"template_px", &O::template_px, "px", "side of the window that is compared, odd", 5, 101});
    visit(Field{"min_ncc", &O::min_ncc, "1", "smallest correlation of a match", 0, 1});
    visit(Field{"square_px", &O::square_px, "px",
                "side of the square round a point whose heights in the last model say how far is searched", 4, 1e5});
    visit(Field{"return_px", &O::return_px, "px", "so near must a match, looked for backwards, come to its point", 0,
                100});
    visit(Field{"grid_px", &O::grid_px, "px",
                "after the levels, match a pixel every so many columns and rows where there is texture; 0: none", 0,
                1000});
    visit(Field{"grid_template_px", &O::grid_template_px, "px", "side of the window of those, odd", 5, 101});
    visit(
        Field{"min_entropy", &O::min_entropy, "bit", "least entropy of the 9 x 9 pixels round one of those", 0, 6.34});
    visit(Field{"whole_mpx", &O::whole_mpx, "Mpx", "larger images are matched at reduced size first", 0.01, 1e5});
  }
};

/// What a level did.
struct LevelCount {
  double threshold = 0;  ///< 0: the grid
  int shrink = 1;        ///< the images were worked on at 1 / shrink of their size
  std::size_t interest = 0, matched = 0;
  std::size_t grown = 0;          ///< found by spreading, of the grid
  std::size_t spikes = 0;         ///< of both
  double median_interval_px = 0;  ///< searched along the row; 0: near planes of a reduced pair
  std::size_t least = 0;          ///< points without which it does not take the place of the model it was found with
  bool is_dropped = false;        ///< it had fewer
};

struct LevelSurface {
  std::vector<LevelPoint> points;
  std::vector<LevelCount> levels;
};

/// The surface of an epipolar pair by levels (Karfis 2009, 6-7): interest points of a high threshold are matched near
/// what a first model predicts, make the next model, and so on with falling thresholds. `guide` is the first model, the
/// points of the relative orientation. In each level
///   - the disparity of a point is predicted in the triangles of the model. That is where its ray meets the model
///     (monoplotting): planes in space are planes in column, row and disparity;
///   - the interval of columns is that of the model's disparities in a square round the point, and the predicted one,
///     widened by two pixels and by half the distance of the nearest point of the model (a slope of 45 degrees); rows
///     by row_sigma_px, the standard deviation of the row of the epipolar line there: one and three of them on either
///     side;
///   - the best correlation in it is taken, when it is good enough and comes back. Windows follow the slope of the
///     surface: that of the nearest point, none, that of the model's triangle, or where none of these is enough the
///     best of eight directions;
///   - it is measured by least squares: disparity and its gradient, gain and offset of grey values;
///   - spikes go: points that fewer than four of the 16 nearest bear out, until none goes. Two points bear each other
///     out when the mean of their planes leads from one to the other within half a pixel and a tenth of their distance.
///     (Karfis' filter takes mean and standard deviation in a circle, which never rejects anything among fewer than
///     eleven points, nor a third of wrong ones; a median would reject roofs with few points and hide spikes on
///     slopes.)
/// Matches of the grid then spread (grown()), and spikes go once more.
/// Images larger than `whole_mpx` are matched so at reduced size, with a grid of 4 px; points of the grid, or of the
/// last threshold, are then looked for near the planes of the six nearest of these, again there and back, and measured.
/// Of more than two million points those of the largest corner measure are taken. Memory: the images and some 300 bytes
/// a point. Same bits for any number of threads. Errors: images of different heights, fewer than three points of the
/// guide that do not lie on a line, options, stopped.
[[nodiscard]] Result<LevelSurface> match_by_levels(
    const GreyImage& left, const GreyImage& right, std::span<const LevelPoint> guide,
    const std::function<double(const Eigen::Vector2d& left_px)>& row_sigma_px, const LevelOptions& options,
    const Run& run);

/// Those that are no spikes: see match_by_levels().
[[nodiscard]] std::vector<LevelPoint> without_spikes(std::vector<LevelPoint> points, const Run& run = {});

}  // namespace collinea
