// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "collinea/base/options.h"
#include "collinea/base/result.h"
#include "collinea/epipolar/pair_point.h"
#include "collinea/epipolar/pair_shape.h"
#include "collinea/epipolar/relative_elements.h"
#include "collinea/epipolar/relative_search.h"
#include "collinea/geometry/rigid3.h"

namespace collinea {

/// From where a relative orientation begins.
enum class PairStart : std::uint8_t { kRobust, kNearVertical, kLinear, kGrid };
inline constexpr Word<PairStart> kPairStartWords[] = {
    {PairStart::kRobust, "robust",
     "five-point samples and their least median: any attitudes, nearly half may be wrong"},
    {PairStart::kNearVertical, "near_vertical", "base along x, no rotation"},
    {PairStart::kLinear, "linear", "the linear equation of y-parallaxes: attitudes alike within some degrees"},
    {PairStart::kGrid, "grid", "exhaustive search over the sphere of attitudes: any attitudes, no gross errors"}};
[[nodiscard]] constexpr std::span<const Word<PairStart>> words(PairStart) { return kPairStartWords; }

/// How gross errors are rejected: always the worst one, then the orientation is made again.
enum class PairRejection : std::uint8_t { kSnooping, kResidual, kNone };
inline constexpr Word<PairRejection> kPairRejectionWords[] = {
    {PairRejection::kSnooping, "snooping", "data snooping: the residual over its standard deviation, tested at alpha"},
    {PairRejection::kResidual, "residual", "a residual over 2.67 sigma0, whatever its standard deviation"},
    {PairRejection::kNone, "none", "nothing is rejected"}};
[[nodiscard]] constexpr std::span<const Word<PairRejection>> words(PairRejection) { return kPairRejectionWords; }

/// Weights by where points lie, so that a crowd in a corner does not rule the orientation.
enum class PairWeights : std::uint8_t { kEqual, kCells, kGruber };
inline constexpr Word<PairWeights> kPairWeightsWords[] = {
    {PairWeights::kEqual, "equal", "by the standard deviations alone"},
    {PairWeights::kCells, "cells", "each cell of 5 x 5 over the common area weighs the same"},
    {PairWeights::kGruber, "gruber", "each of the six zones around the von Gruber points weighs the same"}};
[[nodiscard]] constexpr std::span<const Word<PairWeights>> words(PairWeights) { return kPairWeightsWords; }

struct RelativeOptions {
  PairStart start = PairStart::kRobust;
  PairRejection rejection = PairRejection::kSnooping;
  double alpha = 0.001;
  double residual_limit = 2.67;
  PairWeights weights = PairWeights::kEqual;
  bool sigma_known = false;  ///< covariances and tests by the sigmas as given; else by sigma0 as estimated

  template <class Visit>
  static void describe(Visit&& visit) {
    using O = RelativeOptions;
    visit(Field{"start", &O::start, "", "approximate values"});
    visit(Field{"rejection", &O::rejection, "", "how points with gross errors are found"});
    visit(Field{"alpha", &O::alpha, "1", "chance of rejecting a good point by data snooping", 1e-9, 0.5});
    visit(Field{"residual_limit", &O::residual_limit, "1", "largest residual of residual, times sigma0", 1, 100});
    visit(Field{"weights", &O::weights, "", "weights of points by their distribution"});
  }
};

/// A measured point after the orientation.
struct PairResidual {
  Eigen::Vector2d first = {0, 0}, second = {0, 0};  ///< adjusted minus observed; of rejected points what it would take
  double y_parallax = 0;    ///< by how much the rays miss each other, across the base at image scale (for a base along
                            ///< +-x y2 - y1 of photographs, y up)
  double redundancy = 0;    ///< share of an error that shows in the residual; of rejected points 1
  double standardised = 0;  ///< the residual over its standard deviation by the sigmas as given; all four are alike
  double largest = 0;       ///< the longer residual of the two images over the sigma of its coordinates
  bool used = true;
};

/// Relative orientation of a pair by least squares. Coordinates of all points are observations l, with the condition
///     C(x, l + v) = b . (q1 x R' q2) = 0,   linearised  A dx + B v + w = 0,  v' P v = min
/// in five unknowns x (changed()): the Gauss-Helmert model, linearised at the adjusted coordinates.
/// Rank 5 with five points and more, unless points and base lie on a critical surface (pair_shape.h).
struct RelativeOrientation {
  Rigid3 second_from_first;    ///< translation of unit length; points lie in front of both cameras
  Matrix5 covariance;          ///< of changed(), for the sigmas as given: times sigma0^2 where these are unknown
  Matrix5 normal;              ///< normal matrix of changed(), for the sigmas as given
  double sigma0 = 0;           ///< of unit weight: 1 where the sigmas are true; 0 without redundancy
  double redundancy = 0;       ///< points used less five (weights by distribution take some away)
  double variance_factor = 1;  ///< by which covariances were asked to be multiplied: 1 (sigma known) or sigma0^2
  double limit = 0;            ///< of standardised residuals: of data snooping
  int iterations = 0;          ///< of the last adjustment
  int used = 0;                ///< points
  int in_front = 0;            ///< of those used, in front of both cameras
  std::vector<int> rejected;   ///< in the order of their rejection
  std::vector<PairResidual> residuals;        ///< of all points
  std::optional<RelativeSearch> search = {};  ///< where the start was PairStart::kGrid

  /// The covariance to be stated.
  [[nodiscard]] Matrix5 stated_covariance() const { return covariance * variance_factor; }
};

/// Errors: fewer than five points (eight for PairStart::kRobust: it turns to kGrid below), sigmas that are not
/// positive, no start, points that leave the orientation undetermined (the message names the critical surface where
/// there is one), no convergence. 1000 points without robust start: below 1 ms. `given` takes the place of the start
/// asked for. Sources: Mussio 3.3.2; Karfis 3.4 with its errata (M = B P^-1 B', v = -P^-1 B' M^-1 (w + A x)); rejection
/// by the residual: Karfis 3.5.
[[nodiscard]] Result<RelativeOrientation> relative_orientation(std::span<const PairPoint> points,
                                                               const RelativeOptions& options, std::uint64_t seed,
                                                               const std::optional<Rigid3>& given = {});

/// The same of a motion that is given, with the covariance of changed(): nothing is estimated of it. Residuals are what
/// each point takes to lie on its epipolar line, sigma0 is their scatter, tests and rejection are by it; every point
/// has the redundancy 1. `covariance` becomes what is stated. Errors: fewer than five points, sigmas that are not
/// positive.
[[nodiscard]] Result<RelativeOrientation> given_orientation(std::span<const PairPoint> points,
                                                            const Rigid3& second_from_first, const Matrix5& covariance,
                                                            const RelativeOptions& options);

/// A pair whose points leave the orientation undetermined, at one of the motions that fit them.
struct CriticalPair {
  Rigid3 second_from_first;
  PairShape shape;
};
/// What can be said of points of which relative_orientation() said that they leave it undetermined: all of them, from
/// the start asked for, as far as the iteration goes. Nothing where fewer than five lie in front of both cameras there.
[[nodiscard]] std::optional<CriticalPair> critical_pair(std::span<const PairPoint> points,
                                                        const RelativeOptions& options, std::uint64_t seed);

/// The other orientation that images of a plane allow: H = R + t n' / d has two decompositions with the points in front
/// of both cameras (Ma, Soatto, Kosecka, Sastry 2004, 5.3). `plane` is that of the shape of the first one; the second
/// decomposition is the start of least squares of the same points, nothing rejected. Of a true plane its sigma0 is that
/// of the first one; the more the points depart from the plane, the larger. Nothing for a plane through a projection
/// centre, without a base across it, and where the iteration fails or returns to the first one (1e-6 rad).
[[nodiscard]] std::optional<RelativeOrientation> second_orientation(const Rigid3& second_from_first,
                                                                    const PairShape& shape,
                                                                    std::span<const PairPoint> used,
                                                                    const RelativeOptions& options);

/// One of the four motions with the same coplanarity: the second camera turned by half a turn about the base, and the
/// base the other way round (Mussio 3.1.4).
struct RelativeSolution {
  Rigid3 second_from_first;
  int in_front = 0;  ///< points in front of both cameras
};
/// That with most points in front of both cameras first: the choice.
[[nodiscard]] std::array<RelativeSolution, 4> relative_solutions(const Rigid3& second_from_first,
                                                                 std::span<const PairPoint> points);

/// Factors of the weights of points by where they lie in the first image, with the mean 1. They change what is
/// estimated, not what is known of the measurements: covariances stay true to the sigmas.
[[nodiscard]] std::vector<double> distribution_weights(std::span<const PairPoint> points, PairWeights weights);

}  // namespace collinea
