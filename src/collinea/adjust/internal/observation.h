// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "collinea/adjust/internal/problem.h"

namespace collinea::bundle {

struct BlockMotion;
struct MotionNormals;
struct DatumPart;
class MotionsWithAuxiliaries;

/// Where observations are summed up to normal equations.
class ObservationSink {
 public:
  virtual ~ObservationSink() = default;
  /// One observation: its derivatives by the unknowns, 1 / sigma (times the root of its robust weight), and its
  /// residual in these units.
  virtual void add(const Row& row, double inverse_sigma, double residual) = 0;
  /// Observations by one pose alone: an element of the lower triangle of their normal matrix, and of its right side.
  virtual void add_to_pose(int row, int column, double value) = 0;
  virtual void add_to_right(int row, double value) = 0;
};

/// What every kind of observation says of itself, and how it is treated unless it says so itself. A kind has the items
/// of a table in Problem, of up to kAxes coordinates each that share a robust loss, and
///
///     for_each(problem, visit)               visits the items that take part
///     residual(problem, state, item)         given minus computed [m] or [rad]
///     inverse_sigma(problem, item)           1 / sigma of each coordinate; 0: not given
///     row(problem, state, item, axis)        derivatives of a computed coordinate by the reduced unknowns
///
/// A kind that observes the block as a whole says so, for the gauge and for the datum, where it does:
///
///     add_to_gauge(problem, state, motion, normals)   its observations of a block that was moved as a whole
///     observe_motions(problem, state, parts)          which motions of its part each item sees (a kind of points: of
///                                                     point p, behind `state`)
///     observe_rows(problem, state, parts, rows)       the same of items that also see unknowns of their own
///     for_each_tied_images(problem, visit)            images that an item ties to each other, as two free images
///     for_each_tied_points(problem, visit)            points, as two numbers
///
/// Kinds that are tested for gross errors (kIsTested) also name their group and source; see ObservationGroup and
/// TestedObservation. Those with a robust loss (kIsRobust) say by what they are given (kGivenBy, an ObservationSource),
/// whose groups share that loss. Image points, whose loops have to be fast, are a kind of their own:
/// kind_image_point.h.
template <class Kind, int kAxes>
struct ObservationKind {
  using Vector = Eigen::Matrix<double, kAxes, 1>;
  static constexpr int kSize = kAxes;
  static constexpr bool kIsTested = true;
  static constexpr bool kIsRobust = false;
  static constexpr bool kIsOfPosition = true;  ///< a motion of the whole block changes it
  static constexpr bool kIsOfPoint = false;    ///< it enters the equations of its point, before that is eliminated

  /// Where it has items, the block as a whole can be placed by them.
  static bool positions_block(const Problem&) { return false; }
  /// add_to_gauge() has all that this kind sees of a motion of the whole block.
  static bool is_gauge_complete(const Problem&) { return true; }
  /// Its rows have to be looked at for the datum (observe_rows), whatever unknowns there are.
  static bool needs_rows_for_datum(const Problem&) { return false; }

  static Loss loss(const Problem&) { return {}; }

  /// How many coordinates of an item are given.
  static long count(const Problem& problem, const auto& item) {
    return (Kind::inverse_sigma(problem, item).array() > 0).count();
  }

  /// The residual in sigmas.
  static Vector whitened(const Problem& problem, const State& state, const auto& item) {
    return Kind::residual(problem, state, item).cwiseProduct(Kind::inverse_sigma(problem, item));
  }

  static double squared(const Problem& problem, const State& state, const auto& item) {
    return Kind::whitened(problem, state, item).squaredNorm();
  }

  /// Adds an item to the normal equations; answers its cost.
  static double add(const Problem& problem, const State& state, const auto& item, ObservationSink& sink) {
    const Vector residual = Kind::whitened(problem, state, item), inverse_sigma = Kind::inverse_sigma(problem, item);
    const double s = residual.squaredNorm(), root = std::sqrt(Kind::loss(problem).weight(s));
    for (int axis = 0; axis < kAxes; ++axis)
      sink.add(Kind::row(problem, state, item, axis), root * inverse_sigma[axis], root * residual[axis]);
    return Kind::loss(problem).cost(s);
  }

  /// The residual in sigmas after the step `reduced` of the reduced unknowns, by the linear model. `next`: the state
  /// after that step.
  static Vector predicted(const Problem& problem, const State& state, const State& next,
                          const std::vector<double>& reduced, const auto& item) {
    static_cast<void>(next);
    return Kind::whitened(problem, state, item) -
           change(problem, state, reduced, item).cwiseProduct(Kind::inverse_sigma(problem, item));
  }

  /// Computed coordinates after a step minus those before, by the linear model.
  static Vector change(const Problem& problem, const State& state, const std::vector<double>& reduced,
                       const auto& item) {
    Vector change;
    for (int axis = 0; axis < kAxes; ++axis) {
      change[axis] = 0;
      for (const RowPart& part : Kind::row(problem, state, item, axis))
        change[axis] += part.derivative * reduced[static_cast<std::size_t>(part.row)];
    }
    return change;
  }

  static double sigma(const Problem& problem, const auto& item, int axis) {
    return 1 / Kind::inverse_sigma(problem, item)[axis];
  }

  /// The element of the hat matrix of a coordinate, from the cofactor of its computed value.
  static double leverage(double weight, double inverse_sigma, double cofactor) {
    return weight * inverse_sigma * inverse_sigma * cofactor;
  }
};

}  // namespace collinea::bundle
