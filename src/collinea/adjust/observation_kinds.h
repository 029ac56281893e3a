// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "collinea/adjust/internal/kind_attitude.h"
#include "collinea/adjust/internal/kind_control_coordinate.h"
#include "collinea/adjust/internal/kind_film.h"
#include "collinea/adjust/internal/kind_gnss_position.h"
#include "collinea/adjust/internal/kind_prior.h"
#include "collinea/adjust/internal/kind_vertical.h"
#include "collinea/adjust/kind_geodetic.h"
#include "collinea/adjust/kind_image_point.h"

namespace collinea::bundle {

/// All kinds of observations. A new kind is its file, an entry here and in each order below, and its table in Problem.
using ObservationKinds = std::tuple<ImagePoint, GnssPosition, Vertical, CameraPrior, AuxiliaryPrior, ControlCoordinate,
                                    Geodetic, Attitude, FilmDeformation>;

inline constexpr std::array kEvery = {0, 1, 2, 3, 4, 5, 6, 7, 8};
/// All beside image points, which are summed up with their points: the order in which they enter the normal equations,
/// in which their squares are summed up to sigma0, and in which they are tested. Sums of floating point numbers depend
/// on it.
inline constexpr std::array kInNormals = {1, 2, 3, 4, 5, 6, 7, 8};
inline constexpr std::array kInSquares = {1, 2, 3, 5, 6, 4, 7, 8};
inline constexpr std::array kInTests = {5, 1, 2, 3, 6, 7, 4, 8};
/// Those with unknowns of their own in the order in which the datum sees them, and those whose items are points.
inline constexpr std::array kInDatum = {6, 1, 7};
inline constexpr std::array kOfPoints = {5, 0};
static_assert(kEvery.size() == std::tuple_size_v<ObservationKinds> && kInNormals.size() + 1 == kEvery.size());
static_assert(std::ranges::is_permutation(kInSquares, kInNormals) && std::ranges::is_permutation(kInTests, kInNormals));
static_assert(
    []<std::size_t... i>(std::index_sequence<i...>) {
      const auto in = [](const auto& order, int kind) { return std::ranges::count(order, kind) == 1; };
      return ((std::tuple_element_t<i, ObservationKinds>::kIsOfPoint == in(kOfPoints, int(i))) && ...);
    }(std::make_index_sequence<kEvery.size()>{}),
    "the kinds that say so are those of points");

/// Calls visit.operator()<Kind>() for each kind.
template <const auto& order = kInNormals, class Visit>
void for_each_kind(Visit&& visit) {
  [&]<std::size_t... i>(std::index_sequence<i...>) {
    (visit.template operator()<std::tuple_element_t<order[i], ObservationKinds>>(), ...);
  }
  (std::make_index_sequence<order.size()>{});
}

/// One coordinate of an observation at the current unknowns.
struct ObservationRow {
  double residual = 0;  ///< given minus computed [m], [rad] or the unit of a parameter
  double inverse_sigma = 0;
  double weight = 1;  ///< by the robust loss
  Row derivatives;    ///< of the computed coordinate, by the reduced unknowns
};

/// Visits every given coordinate of a kind as visit(item, axis, row).
template <class Kind, class Visit>
void for_each_row(const Problem& problem, const State& state, Visit&& visit) {
  Kind::for_each(problem, [&](const auto& item) {
    const typename Kind::Vector residual = Kind::residual(problem, state, item),
                                inverse_sigma = Kind::inverse_sigma(problem, item);
    const double weight = Kind::loss(problem).weight(Kind::squared(problem, state, item));
    for (int axis = 0; axis < Kind::kSize; ++axis)
      if (inverse_sigma[axis] > 0)
        visit(item, axis,
              ObservationRow{residual[axis], inverse_sigma[axis], weight, Kind::row(problem, state, item, axis)});
  });
}

}  // namespace collinea::bundle
